// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "machine/calibrate/camera/run.h"
#include "machine/calibrate/table/run.h"
#include "machine/plate/pictures.h"
#include "machine/sim/sim_plate.h"
#include "vision/picture/files/folder.h"
#include "vision/picture/files/image_io.h"
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::string_view kMachine = R"([[vision.tool]]
number = 1
shape = "disc"
size_mm = 0.3
polarity = "dark"
[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [45.0, -3.0]
[sim]
seed = 5
noise = 2
background = 0.5
target_level = 0.8
)";
/// Four tags between the dots, and one in place of the dot (4, 3).
constexpr std::string_view kPlate = R"([plate]
columns = 6
rows = 5
pitch_mm = 0.8
dot_diameter_mm = 0.3
certified = true
[tags]
size_mm = 0.38
first_id = 20
first_cell = [0.5, 0.5]
step_cells = [2, 2]
columns = 2
rows = 2
[[tag]]
id = 7
cell = [4, 3]
angle_deg = 180
)";
constexpr double kPitch_mm = 0.8;
/// Error that a detector and rounding leave, as in plate_pictures_test.cc.
constexpr Length kNear = um(1.5);
const PlatePose kLies{0.3, {100, 80}};
const PlatePose kTurned{1.9, {104, 79}};

/// A plate under a virtual machine, which looks at it from over every place of a dot.
class TaggedPlateTest : public ::testing::Test {
 protected:
  using Error = std::function<Eigen::Vector2d(const Position<frame::Machine>&)>;

  void SetUp() override {
    const auto config =
        test::config_with_camera(folder_.path(), test::test_camera(240, 200), kMachine);
    ASSERT_TRUE(config) << config.error().text();
    config_ = *config;
    plate_ = plate_of(kPlate);
    printed_ = *plate_.tags;
  }

  static CalibrationPlate plate_of(std::string_view text) {
    const auto plate = parse_plate(text, "plate.toml");
    EXPECT_TRUE(plate) << plate.error().text();
    return plate.value_or(CalibrationPlate());
  }

  SimPlateOptions what_lies(const PlatePose& lies) const {
    SimPlateOptions options;
    const std::vector<PlateDot> dots = plate_.dots();
    const std::vector<bool> is_covered = plate_.covered_dots();
    for (std::size_t i = 0; i < dots.size(); ++i) {
      if (!is_covered[i]) options.marks.push_back(place_in(lies, dots[i].place));
    }
    for (const PlateTag& tag : printed_.tags) {
      Target target;
      target.shape = Shape::AprilTag;
      target.size = printed_.size;
      target.polarity = printed_.polarity;
      target.tag_id = tag.id;
      options.others.push_back(
          {target, place_in(lies, tag.center), tag.turn + rad(lies.angle_rad)});
    }
    return options;
  }

  /// Takes the pictures of a pose; the stage errs by `error_mm` of where the spindle is sent.
  void record(std::size_t i_pose, const PlatePose& lies, const Error& error_mm = {}) {
    lies_.resize(i_pose + 1);
    lies_[i_pose] = lies;
    SimPlateOptions options = what_lies(lies);
    options.error_mm = error_mm;
    auto machine = SimPlate::create(config_, std::move(options));
    ASSERT_TRUE(machine) << machine.error().text();
    const auto folder = folder_.path() / "looks" / std::to_string(i_pose);
    std::filesystem::create_directories(folder);
    std::string csv = "file,x,y\n";
    int n = 0;
    for (const PlateDot& dot : plate_.dots()) {
      const auto axis = place_in(lies, dot.place);
      ASSERT_TRUE(machine->move_to(config_.spindle_camera.spindle_to_see(axis)));
      const auto image = machine->take();
      ASSERT_TRUE(image);
      const std::string name = fmt::format("{}.png", n++);
      ASSERT_TRUE(write_png(folder / name, *image));
      csv += fmt::format("{},{},{}\n", name, axis.in_mm().x(), axis.in_mm().y());
    }
    ASSERT_TRUE(write_file(folder / "images.csv", csv));
  }

  /// Changes what images.csv of a pose says.
  void change_list(std::size_t i_pose,
                   const std::function<void(std::vector<PictureRow>&)>& change) const {
    const auto path = folder_.path() / "looks" / std::to_string(i_pose);
    auto folder = read_picture_folder(path);
    ASSERT_TRUE(folder) << folder.error().text();
    change(folder->rows);
    ASSERT_TRUE(write_file(path / "images.csv", format_images_csv(folder->rows)));
  }

  Expected<MarkSights> look() const {
    PANELCAL_TRY(const auto folders, read_plate_folders(folder_.path() / "looks", plate_));
    return look_at_plate(config_, plate_, folders);
  }

  /// Every look is at the dot that it is said to be, and at none that a tag covers.
  void expect_right_dots(const MarkSights& sights) const {
    const CameraModel model =
        config_.sim->camera ? CameraModel(*config_.sim->camera) : config_.camera->model();
    const std::vector<bool> is_covered = plate_.covered_dots();
    for (const CameraObservation& look : sights.data.seen) {
      const PlateView& view = sights.data.views[look.i_view];
      EXPECT_FALSE(is_covered[look.i_dot]);
      const auto truth = place_in(lies_[view.i_pose], sights.data.dots[look.i_dot].place);
      const auto seen =
          view.axis_at + displacement_mm<frame::Machine>(model(look.seen.position).in_mm());
      EXPECT_THAT(seen, test::IsNearPosition(truth, kNear)) << sights.names[look.i_view];
    }
  }

  /// A stage that stands a pitch off where it is sent to see the place of a dot, as kLies has it.
  Error a_pitch_off_over(int column, int row) const {
    const auto where = config_.spindle_camera.spindle_to_see(
        place_in(kLies, plate_.dots()[plate_.index(column, row)].place));
    const Eigen::Vector2d pitch_mm(kPitch_mm * std::cos(kLies.angle_rad),
                                   kPitch_mm * std::sin(kLies.angle_rad));
    return [=](const Position<frame::Machine>& spindle) -> Eigen::Vector2d {
      const bool is_there = (spindle - where).in_mm().norm() < 0.01;
      return is_there ? pitch_mm : Eigen::Vector2d::Zero();
    };
  }

  test::TemporaryFolder folder_;
  MachineConfig config_;
  CalibrationPlate plate_;
  PlateTags printed_;  ///< tags that are really on the plate
  std::vector<PlatePose> lies_;
};

TEST_F(TaggedPlateTest, TagsSayHowItLay) {
  record(0, kLies);
  record(1, kTurned);
  const auto sights = look();
  ASSERT_TRUE(sights) << sights.error().text();
  EXPECT_EQ(sights->data.views.size(), 60U);
  EXPECT_TRUE(sights->missed.empty());
  EXPECT_TRUE(sights->left_out.empty());
  EXPECT_GT(sights->data.seen.size(), 180U);
  expect_right_dots(*sights);
}

TEST_F(TaggedPlateTest, WhatTheFileSaysOfThePoseIsOfNoMatter) {
  record(0, kLies);
  const auto without = look();
  ASSERT_TRUE(without) << without.error().text();
  const double turned_rad = kLies.angle_rad + deg(20).in_rad();
  plate_.poses = {{turned_rad, kLies.shift_mm + 3 * kPitch_mm * Eigen::Vector2d::UnitX()}};
  const auto with = look();
  ASSERT_TRUE(with) << with.error().text();
  expect_right_dots(*with);
  ASSERT_EQ(with->data.seen.size(), without->data.seen.size());
  for (std::size_t i = 0; i < with->data.seen.size(); ++i) {
    EXPECT_EQ(with->data.seen[i].i_dot, without->data.seen[i].i_dot);
  }
  // Dots alone do not make one plate of such a pose.
  plate_.tags.reset();
  const auto misled = look();
  EXPECT_FALSE(misled);
}

TEST_F(TaggedPlateTest, ACameraThatIsToBeCalibratedWillDo) {
  config_.sim->camera = config_.camera->parameters;
  config_.sim->camera->scale_mm_per_px *= 1.03;
  config_.sim->camera->rotation_rad += 0.05;
  record(0, kLies);
  const auto sights = look();
  ASSERT_TRUE(sights) << sights.error().text();
  EXPECT_TRUE(sights->left_out.empty());
  EXPECT_GT(sights->data.seen.size(), 90U);
  expect_right_dots(*sights);
  CameraRunOptions options;
  options.form = CameraForm::Radial;
  const auto run = fit_camera_run(config_, *sights, options);
  ASSERT_TRUE(run) << run.error().text();
  EXPECT_NEAR(run->fit.parameters.rotation_rad,
              config_.sim->camera->rotation_rad,
              4 * std::sqrt(run->fit.covariance(1, 1)));
}

TEST_F(TaggedPlateTest, APictureWithoutATagFollowsFromTheOthers) {
  std::erase_if(printed_.tags, [](const PlateTag& tag) { return tag.id != 20; });
  record(0, kLies);
  const auto sights = look();
  ASSERT_TRUE(sights) << sights.error().text();
  expect_right_dots(*sights);
  // The far corner is 4.6 mm from the one tag; pictures reach 1.6 mm from their middle.
  const bool is_seen = std::ranges::any_of(sights->data.seen, [&](const CameraObservation& look) {
    return look.i_dot == plate_.index(5, 4);
  });
  EXPECT_TRUE(is_seen);
  // Those that show the tag are not among them; the far corner's is.
  EXPECT_THAT(sights->without_tag, Contains("0/29.png"));
  EXPECT_THAT(sights->without_tag, Not(Contains("0/0.png")));
  TableRun run;
  run.sights = table_sights(config_, *sights);
  EXPECT_THAT(
      report(run),
      HasSubstr(fmt::format("  pictures without a tag: {} (from 0/", sights->without_tag.size())));
  CameraRun camera;
  camera.sights = *sights;
  EXPECT_THAT(report(camera), HasSubstr("  pictures without a tag: "));
}

TEST_F(TaggedPlateTest, APictureWithoutATagIsNotCheckedWhichIsSaid) {
  std::erase_if(printed_.tags, [](const PlateTag& tag) { return tag.id != 20; });
  record(0, kLies, a_pitch_off_over(3, 2));
  const auto sights = look();
  ASSERT_TRUE(sights) << sights.error().text();
  EXPECT_TRUE(sights->left_out.empty());
  EXPECT_THAT(sights->without_tag, Contains("0/15.png"));
}

TEST_F(TaggedPlateTest, RefusesThatAllFollowFromOnePictureWithTags) {
  std::erase_if(printed_.tags, [](const PlateTag& tag) { return tag.id != 20; });
  record(0, kLies, a_pitch_off_over(0, 0));
  change_list(0, [](std::vector<PictureRow>& rows) {
    std::erase_if(rows, [](const PictureRow& row) {  // tag 20 is beside the first
      const int n = std::stoi(row.file);
      return n != 0 && n % 6 < 3 && n / 6 < 3;
    });
  });
  EXPECT_THAT(look(), FailsWith(Code::CalibrationData, "0.png"));
  // One picture alone is not shifted against any other.
  change_list(0, [](std::vector<PictureRow>& rows) { rows.resize(1); });
  const auto alone = look();
  ASSERT_TRUE(alone) << alone.error().text();
  EXPECT_TRUE(alone->without_tag.empty());
}

TEST_F(TaggedPlateTest, AFolderWithoutPicturesOfTheZoomIsSkipped) {
  record(0, kLies);
  record(1, kTurned);
  record(2, kLies);
  change_list(1, [](std::vector<PictureRow>& rows) {
    for (PictureRow& row : rows) row.zoom = 2;
  });
  const auto sights = look();
  ASSERT_TRUE(sights) << sights.error().text();
  EXPECT_EQ(sights->n_skipped, 30);
  EXPECT_EQ(sights->data.views.size(), 60U);
  // The fit wants its poses numbered without gaps.
  EXPECT_EQ(sights->data.views.back().i_pose, 1U);
  // So is a plate without tags.
  plate_.tags.reset();
  plate_.poses = {kLies, kTurned, kLies};
  const auto untagged = look();
  ASSERT_TRUE(untagged) << untagged.error().text();
  EXPECT_EQ(untagged->n_skipped, 30);
  EXPECT_EQ(untagged->data.views.back().i_pose, 1U);
}

TEST_F(TaggedPlateTest, AStopThatIsAPitchOffIsLeftOut) {
  record(0, kLies, a_pitch_off_over(1, 1));
  const auto sights = look();
  ASSERT_TRUE(sights) << sights.error().text();
  expect_right_dots(*sights);
  ASSERT_EQ(sights->left_out.size(), 1U);
  EXPECT_EQ(sights->left_out[0].picture, "0/7.png");
  EXPECT_THAT(sights->left_out[0].reason, HasSubstr("mm beside where the others have it"));
  // Its tags had a say, so its digest is among the others'.
  EXPECT_EQ(sights->inputs.size(), 30U);
  EXPECT_THAT(sights->inputs, Contains(::testing::Field(&LedgerInput::name, "0/7.png")));
  TableRun run;
  run.sights = table_sights(config_, *sights);
  EXPECT_THAT(report(run), HasSubstr("  without 0/7.png: tag "));
  // Dots alone cannot tell: every one is where another one should be.
  plate_.tags.reset();
  plate_.poses = {kLies};
  const auto untold = look();
  ASSERT_TRUE(untold) << untold.error().text();
  EXPECT_TRUE(untold->left_out.empty());
}

TEST_F(TaggedPlateTest, RefusesTagsThatContradictOneAnother) {
  // The plate was made by a mirrored drawing, but for what each tag shows.
  for (PlateTag& tag : printed_.tags) {
    if (tag.id >= 20) tag.id ^= 1;
  }
  record(0, kLies);
  EXPECT_THAT(look(), FailsWith(Code::CalibrationData, "tag 2"));
}

TEST_F(TaggedPlateTest, RefusesDotsThatLieBesideTheTags) {
  for (PlateTag& tag : printed_.tags) {
    tag.center = tag.center + displacement_mm<frame::Plate>(0.28 * kPitch_mm, 0);
  }
  std::erase_if(printed_.tags, [](const PlateTag& tag) { return tag.id == 7; });
  record(0, kLies);
  EXPECT_THAT(look(), FailsWith(Code::CalibrationData, "mm rms"));
}

TEST_F(TaggedPlateTest, SaysWhichTagsThereAreInstead) {
  printed_.size = mm(0.3);
  record(0, kLies);
  EXPECT_THAT(look(), FailsWith(Code::CalibrationData, "tag"));
  EXPECT_THAT(look(), FailsWith(Code::CalibrationData, " mm"));
  printed_ = *plate_.tags;
  for (PlateTag& tag : printed_.tags) tag.id += 100;
  record(0, kLies);
  EXPECT_THAT(look(), FailsWith(Code::CalibrationData, "tag 1"));
}

TEST_F(TaggedPlateTest, TagsMayBeNegatives) {
  printed_.polarity = Polarity::Dark;
  record(0, kLies);
  EXPECT_THAT(look(), FailsWith(Code::CalibrationData));
  plate_.tags->polarity = Polarity::Dark;
  const auto sights = look();
  ASSERT_TRUE(sights) << sights.error().text();
  expect_right_dots(*sights);
}

TEST_F(TaggedPlateTest, PicturesOfOnePoseNeedNoFolderOfItsNumber) {
  record(0, kLies);
  const auto folders = read_plate_folders(folder_.path() / "looks" / "0", plate_);
  ASSERT_TRUE(folders) << folders.error().text();
  ASSERT_EQ(folders->size(), 1U);
  EXPECT_THAT(read_plate_folders(folder_.path() / "nothing", plate_),
              FailsWith(Code::FileUnreadable, "images.csv"));
}

}  // namespace
}  // namespace panelcal
