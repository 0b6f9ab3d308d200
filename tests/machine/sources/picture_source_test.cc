// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/picture_source.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "calib/base/thread_pool.h"
#include "machine/sim/pictures/recording.h"
#include "machine/sim/sim_machine.h"
#include "machine/sim/truth.h"
#include "vision/picture/files/image_io.h"
#include <gtest/gtest.h>

#include "tests/machine/counted_tasks.h"
#include "tests/machine/small_panel.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::IsNearMatrix;
using test::IsNearPosition;

/// PNG keeps every grey level and images.csv every bit, so only rounding is left.
constexpr Length kSame = mm(1e-9);

/// A recorded run: the pictures in a folder and what was measured while they were taken.
class PictureSourceTest : public ::testing::Test {
 protected:
  void record(std::string_view program_text, std::string_view sim = "neighbors = 2\n") {
    config_ = test::small_config(folder_.path(), sim);
    config_.sim->panel_offset = panel_offset_;
    program_ = test::program_of(std::string(program_text));
    auto machine = SimMachine::create(config_, program_);
    ASSERT_TRUE(machine) << machine.error().text();
    DiagnosticLog log;
    auto recording = record_pictures(program_, config_, *machine, pictures(), log);
    ASSERT_TRUE(recording) << recording.error().text();
    ASSERT_FALSE(log.has_errors()) << test::all_text(log);
    recording_ = *std::move(recording);
  }
  void SetUp() override { record(test::kSmallProgram); }

  std::filesystem::path pictures() const { return folder_.path() / "pictures"; }
  PictureFolder read_folder() const {
    auto folder = read_picture_folder(pictures());
    EXPECT_TRUE(folder) << folder.error().text();
    return folder ? *std::move(folder) : PictureFolder();
  }
  /// As recorded, without the way through images.csv.
  PictureFolder recorded_folder() const { return {pictures(), recording_.rows}; }
  Expected<Measurement> measure(PictureFolder folder, const MeasurementRequest& request) const {
    auto source = PictureSource::create(config_, std::move(folder));
    EXPECT_TRUE(source) << source.error().text();
    return source->measure(request);
  }
  void expect_same_survey(PictureFolder folder) const {
    auto source = PictureSource::create(config_, std::move(folder));
    ASSERT_TRUE(source) << source.error().text();
    DiagnosticLog log;
    const Survey survey = panelcal::survey(program_, config_.walk, *source, log);
    ASSERT_FALSE(log.has_errors()) << test::all_text(log);
    ASSERT_EQ(survey.measurements.size(), recording_.survey.measurements.size());
    for (std::size_t i = 0; i < survey.measurements.size(); ++i) {
      const Measurement& read = survey.measurements[i];
      const Measurement& recorded = recording_.survey.measurements[i];
      EXPECT_THAT(read.measured.position, IsNearPosition(recorded.measured.position, kSame));
      EXPECT_THAT(read.measured.cov, IsNearMatrix(recorded.measured.cov, 1e-12));
      EXPECT_EQ(read.image, recorded.image);
    }
  }

  test::TemporaryFolder folder_;
  Displacement<frame::Actual> panel_offset_ = displacement_mm<frame::Actual>(0.3, -0.2);
  MachineConfig config_;
  Program program_;
  Recording recording_;
};

TEST_F(PictureSourceTest, RecordedPicturesGiveTheRecordedMeasurements) {
  const PictureFolder folder = read_folder();
  ASSERT_EQ(folder.rows.size(), 7u);
  EXPECT_EQ(folder.rows[6].file, "0006.png");
  EXPECT_EQ(folder.rows[6].seq, 6);
  EXPECT_EQ(folder.rows[6].tool, 2);
  expect_same_survey(folder);
}

TEST_F(PictureSourceTest, WithoutSeqTheNearestPictureIsTaken) {
  PictureFolder folder = read_folder();
  for (PictureRow& row : folder.rows) {
    row.seq.reset();
    row.tool.reset();
  }
  std::ranges::reverse(folder.rows);
  expect_same_survey(folder);
}

TEST_F(PictureSourceTest, LookingAheadChangesNoAnswer) {
  config_.vision.search_radius = mm(1);  // so that an answer depends on the expected place
  std::vector<MeasurementRequest> requests;
  for (const Measurement& one : recording_.survey.measurements) requests.push_back(one.request);
  std::vector<MeasurementRequest> elsewhere = requests;
  for (MeasurementRequest& request : elsewhere) {
    request.expected = request.expected + displacement_mm<frame::Actual>(0.05, 0.02);
  }
  std::vector<MeasurementRequest> reversed(requests.rbegin(), requests.rend());
  auto alone = PictureSource::create(config_, read_folder());
  ASSERT_TRUE(alone);
  const std::initializer_list<std::vector<MeasurementRequest>> forecasts = {
      requests, elsewhere, reversed, {}};
  for (const auto& forecast : forecasts) {
    test::CountedTasks tasks;
    auto source = PictureSource::create(config_, read_folder(), {}, &tasks);
    ASSERT_TRUE(source);
    source->foresee([&] { return forecast; });
    for (const MeasurementRequest& request : requests) {
      const auto expected = alone->measure(request);
      const auto measured = source->measure(request);
      ASSERT_TRUE(expected && measured);
      EXPECT_EQ(to_json(*measured), to_json(*expected));
    }
    if (&forecast == forecasts.begin()) {
      EXPECT_EQ(tasks.n_posted, requests.size());
    }
  }
}

TEST_F(PictureSourceTest, AForecastIsAskedForAgainWhenItWasWrong) {
  config_.vision.search_radius = mm(1);
  std::vector<MeasurementRequest> requests;
  for (const Measurement& one : recording_.survey.measurements) requests.push_back(one.request);
  ThreadPool pool(2);
  auto source = PictureSource::create(config_, read_folder(), {}, &pool);
  ASSERT_TRUE(source);
  int n_asked = 0;
  source->foresee([&] {
    std::vector<MeasurementRequest> forecast = requests;
    // At first nothing is known of the shift from the fourth target on.
    for (std::size_t i = 3; i < forecast.size() && n_asked == 0; ++i) {
      forecast[i].expected = forecast[i].expected + displacement_mm<frame::Actual>(0.05, 0.02);
    }
    ++n_asked;
    return forecast;
  });
  for (const MeasurementRequest& request : requests) ASSERT_TRUE(source->measure(request));
  EXPECT_EQ(n_asked, 2);
}

TEST_F(PictureSourceTest, AStoredOffsetMovesWhereLaterPicturesWereTaken) {
  // The target is searched for from another pixel on: a hundredth of one.
  constexpr Length kSought = um(0.1);
  PictureFolder nearest = read_folder();
  for (PictureRow& row : nearest.rows) row.seq.reset();
  for (const PictureFolder& folder : {read_folder(), nearest}) {
    auto source = PictureSource::create(config_, folder);
    ASSERT_TRUE(source) << source.error().text();
    const MeasurementRequest request = recording_.survey.measurements[0].request;
    const auto before = source->measure(request);
    ASSERT_TRUE(before) << before.error().text();
    CalibrationOrder order;
    const auto nobody = source->calibrate(order);  // G39: who should drill?
    ASSERT_TRUE(nobody);
    EXPECT_FALSE(*nobody);
    order.correction.emplace();
    order.correction->deviation = displacement_mm<frame::Machine>(0.02, -0.01);
    const auto answer = source->calibrate(order);
    ASSERT_TRUE(answer && *answer && (*answer)->offset);
    EXPECT_EQ((*answer)->offset->offset,
              config_.spindle_camera.offset - displacement_mm<frame::Machine>(0.02, -0.01));
    const auto after = source->measure(request);
    ASSERT_TRUE(after) << after.error().text();
    EXPECT_THAT(
        after->measured.position,
        IsNearPosition(before->measured.position - displacement_mm<frame::Actual>(0.02, -0.01),
                       kSought));
  }
}

TEST_F(PictureSourceTest, NearestPictureIsOfTheRightVisionTool) {
  PictureFolder folder = read_folder();
  for (PictureRow& row : folder.rows) row.seq.reset();
  const std::vector<PictureRow> right = folder.rows;
  for (PictureRow row : right) {
    row.tool = 99;
    folder.rows.insert(folder.rows.begin(), row);
  }
  expect_same_survey(folder);
}

TEST_F(PictureSourceTest, RecordedInspectionsAreAveraged) {
  record(test::small_program_with("$uvis,insp,2"));
  const PictureFolder folder = recorded_folder();
  ASSERT_EQ(folder.rows.size(), 14u);
  EXPECT_EQ(folder.rows[1].file, "0000_2.png");
  EXPECT_EQ(folder.rows[1].seq, 0);
  expect_same_survey(folder);
}

TEST_F(PictureSourceTest, FourViewsWithInspectionsAreReplayed) {
  record(test::small_program_with("$uvis,insp,2\nG34,1,2.0"));
  const PictureFolder folder = recorded_folder();
  ASSERT_EQ(folder.rows.size(), 3u * 8u + 4u * 2u);
  EXPECT_EQ(folder.rows[2].file, "0000_view2.png");
  EXPECT_EQ(folder.rows[3].file, "0000_view2_2.png");
  expect_same_survey(folder);
}

TEST_F(PictureSourceTest, FourViewsWithoutSeqAreTheNearestPictures) {
  record(test::small_program_with("G34,1,2.0"));
  PictureFolder folder = recorded_folder();
  for (PictureRow& row : folder.rows) row.seq.reset();
  std::ranges::reverse(folder.rows);
  expect_same_survey(folder);
}

TEST_F(PictureSourceTest, FourViewsNeedFourPictures) {
  record(test::small_program_with("G34,1,2.0"));
  PictureFolder folder = recorded_folder();
  folder.rows.erase(folder.rows.begin() + 2);
  EXPECT_THAT(measure(folder, recording_.survey.measurements[0].request),
              FailsWith(Code::PictureMismatch, "seq 0"));
}

TEST_F(PictureSourceTest, SearchIsReplayedAndEndsWhereItsPicturesEnd) {
  panel_offset_ = displacement_mm<frame::Actual>(2.4, -1.7);
  record(test::small_program_with("$uvis,search,on\n$uvis,searcharea,3.5"));
  const PictureFolder folder = recorded_folder();
  EXPECT_GT(folder.rows.size(), 14u);
  EXPECT_EQ(folder.rows[1].file, "0000_view2.png");
  expect_same_survey(folder);
  PictureFolder first_view = folder;
  std::erase_if(first_view.rows, [](const PictureRow& row) { return row.file != "0000.png"; });
  const auto measurement = measure(first_view, recording_.survey.measurements[0].request);
  ASSERT_TRUE(measurement) << measurement.error().text();
  EXPECT_EQ(measurement->status, MeasurementStatus::NotFound);
  EXPECT_EQ(measurement->reason.rfind("not in 1 of ", 0), 0u) << measurement->reason;
}

TEST_F(PictureSourceTest, RefusesFewerPicturesThanInspections) {
  MeasurementRequest request = recording_.survey.measurements[0].request;
  request.settings.inspections = 3;
  EXPECT_THAT(measure(read_folder(), request), FailsWith(Code::PictureMismatch, describe(request)));
}

TEST_F(PictureSourceTest, SaysWhichPictureIsMissing) {
  MeasurementRequest request = recording_.survey.measurements[3].request;
  request.seq = 12;
  EXPECT_THAT(measure(read_folder(), request),
              FailsWith(Code::PictureMissing, "G46 target 12 (line 16)"));
  PictureFolder folder = read_folder();
  for (PictureRow& row : folder.rows) row.seq.reset();
  request.expected = position_mm<frame::Actual>(12, 10);
  EXPECT_THAT(measure(folder, request), FailsWith(Code::PictureMissing, "\"0003.png\""));
  EXPECT_THAT(measure({}, request), FailsWith(Code::PictureMissing));
}

TEST_F(PictureSourceTest, PictureOfAnotherPlaceIsRefused) {
  MeasurementRequest request = recording_.survey.measurements[0].request;
  request.expected = position_mm<frame::Actual>(8, 5);
  EXPECT_THAT(measure(read_folder(), request),
              FailsWith(Code::PictureMissing, "0000.png: error[picture-missing]: "));
}

TEST_F(PictureSourceTest, PictureForAnotherVisionToolIsRefused) {
  PictureFolder folder = read_folder();
  folder.rows[0].tool = 2;
  EXPECT_THAT(measure(folder, recording_.survey.measurements[0].request),
              FailsWith(Code::PictureMismatch, "images.csv:2:1: "));
}

TEST_F(PictureSourceTest, PictureOfAnotherCameraIsRefused) {
  ASSERT_TRUE(write_png(pictures() / "0000.png", Image(100, 80, Image::kFullScale8, 50)));
  EXPECT_THAT(measure(read_folder(), recording_.survey.measurements[0].request),
              FailsWith(Code::PictureMismatch, "100 x 80 px"));
}

TEST_F(PictureSourceTest, EmptyPictureIsAnAnswer) {
  ASSERT_TRUE(write_png(pictures() / "0000.png", Image(280, 240, Image::kFullScale8, 50)));
  const auto measurement = measure(read_folder(), recording_.survey.measurements[0].request);
  ASSERT_TRUE(measurement) << measurement.error().text();
  EXPECT_EQ(measurement->status, MeasurementStatus::NotFound);
  EXPECT_EQ(measurement->image, "0000.png");
}

TEST_F(PictureSourceTest, OnePictureWithoutTheTargetDecides) {
  record(test::small_program_with("$uvis,insp,2"));
  ASSERT_TRUE(write_png(pictures() / "0000_2.png", Image(280, 240, Image::kFullScale8, 50)));
  const auto measurement = measure(recorded_folder(), recording_.survey.measurements[0].request);
  ASSERT_TRUE(measurement) << measurement.error().text();
  EXPECT_EQ(measurement->status, MeasurementStatus::NotFound);
  EXPECT_EQ(measurement->image, "0000_2.png");
  EXPECT_EQ(measurement->reason.rfind("2 of 2 pictures: ", 0), 0u) << measurement->reason;
}

TEST_F(PictureSourceTest, UnreadablePictureIsAnError) {
  std::filesystem::remove(pictures() / "0000.png");
  EXPECT_THAT(measure(read_folder(), recording_.survey.measurements[0].request),
              FailsWith(Code::FileUnreadable, "0000.png"));
}

TEST_F(PictureSourceTest, RefusesWhatCannotBeMeasured) {
  MeasurementRequest request = recording_.survey.measurements[0].request;
  request.settings.tools = {5};
  EXPECT_THAT(measure({}, request), FailsWith(Code::VisionToolUndefined, "vision tool 5"));
  request.settings.tools = {1, 2};
  EXPECT_THAT(measure({}, request), FailsWith(Code::NotSupported, "2 vision tools"));
  MachineConfig blind = config_;
  blind.camera.reset();
  EXPECT_THAT(PictureSource::create(blind, {}), FailsWith(Code::ConfigValue, "[camera]"));
}

TEST_F(PictureSourceTest, ObserverSeesEveryPicture) {
  std::vector<std::int64_t> seen;
  auto source = PictureSource::create(config_, read_folder(), [&](const SeenView& view) {
    seen.push_back(view.request.seq);
    EXPECT_EQ(view.picture.image.height(), 240);
    EXPECT_TRUE(view.detection.best);
  });
  ASSERT_TRUE(source) << source.error().text();
  DiagnosticLog log;
  survey(program_, config_.walk, *source, log);
  EXPECT_EQ(seen, (std::vector<std::int64_t>{0, 1, 2, 3, 4, 5, 6}));
}

TEST_F(PictureSourceTest, RecordingReplacesAnOldFolder) {
  ASSERT_TRUE(write_file(pictures() / "notes.txt", "mine"));
  record("M48\nMETRIC,TZ\nFMAT,2\nVER,1\nT1C0.8\n%\nG90\nG34,1\nG35X5.0Y5.0\nT1\nX5.0Y5.0\nM30\n");
  EXPECT_EQ(read_folder().rows.size(), 1u);
  EXPECT_FALSE(std::filesystem::exists(pictures() / "0001.png"));
  EXPECT_TRUE(std::filesystem::exists(pictures() / "notes.txt"));
}

}  // namespace
}  // namespace panelcal
