// SPDX-License-Identifier: Apache-2.0
// Programs that calibrate while they are measured: on the simulated machine, with devices, and
// replayed.
#include "machine/calibrate/spindle/job_calibration.h"

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/files/digest.h"
#include "machine/sim/sim_coupon.h"
#include "machine/sim/sim_machine.h"
#include "machine/sources/live_source.h"
#include "machine/sources/measurement_file_source.h"
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/machine/calibrate/spindle/coupon_job.h"
#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::IsNearPosition;
using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

/// Five sigmas of a located hole, which is 0.2 um in these pictures.
constexpr Length kLocated = um(1);
/// Of two squared standard scores: passed by one healthy job in 20,000.
constexpr double kMostSquare = 20;

constexpr std::string_view kCoupon = R"([sim.coupon]
drill_wander_um = 3
stage_repeatability_um = 1
[coupon]
origin_mm = [300, 100]
rows_per_run = 3
)";

/// A machine whose offset is 30 and 20 um off what its file says.
MachineConfig machine_with_coupon(const TemporaryFolder& folder, const std::string& more = "") {
  auto config = test::coupon_machine(folder.path(), more + std::string(kCoupon));
  EXPECT_TRUE(config) << config.error().text();
  return std::move(config).value();
}

std::string excellon(std::string_view body) {
  return "M48\nMETRIC,TZ\nFMAT,2\nVER,1\nT1C0.8\n%\nG90\nG34,1\n" + std::string(body) + "M30\n";
}

struct Job {
  Survey survey;
  DiagnosticLog log;
  std::vector<test::Hole> holes;
};

Job run(const Program& program, const MachineConfig& config, MeasurementSource& source) {
  Job job;
  job.survey = survey(program, config.walk, source, job.log);
  if (job.log.has_errors()) return job;
  test::HoleSink sink;
  execute(program, config.walk, job.survey, sink, job.log);
  job.holes = sink.holes();
  return job;
}

Job run_simulated(const std::string& text, const MachineConfig& config) {
  const Program program = test::program_of(text);
  auto machine = SimMachine::create(config, program);
  EXPECT_TRUE(machine) << machine.error().text();
  return run(program, config, *machine);
}

/// Error of a measured place: the simulated panel lies as it is drawn.
Eigen::Vector2d error_mm(const Measurement& m) {
  return m.measured.position.in_mm() - m.request.nominal.in_mm();
}

/// Squared error of a measured place by its covariance.
double squared_score(const Measurement& m, const CalibrationAnswer& calibration) {
  const Eigen::Matrix2d cov_mm2 = m.measured.cov + calibration.offset->cov_mm2;
  return error_mm(m).dot(cov_mm2.inverse() * error_mm(m));
}

TEST(JobCalibration, MakesLaterMeasurementsRight) {
  for (const char* order : {"G39X300.0Y100.0\n", "G39\n", "$uvis,calib\n"}) {
    const TemporaryFolder folder;
    const MachineConfig config = machine_with_coupon(folder);
    const Job job = run_simulated(
        excellon("T1\nG38X350.0Y150.0\n" + std::string(order) + "G38X360.0Y150.0\n"), config);
    const auto at = test::all_text(job.log);
    ASSERT_EQ(job.survey.measurements.size(), 2U) << at;
    ASSERT_EQ(job.survey.calibrations.size(), 1U) << at;
    const CalibrationAnswer& calibration = job.survey.calibrations[0];
    // The camera looks 30 and 20 um farther than believed.
    EXPECT_NEAR(error_mm(job.survey.measurements[0]).x(), -0.03, kLocated.in_mm()) << order;
    EXPECT_NEAR(error_mm(job.survey.measurements[0]).y(), -0.02, kLocated.in_mm()) << order;
    EXPECT_LT(squared_score(job.survey.measurements[1], calibration), kMostSquare) << order;
    // Nine holes of 3 um: about 1 um, which the answer knows.
    EXPECT_LT(error_mm(job.survey.measurements[1]).norm(), 0.005) << order;
    EXPECT_LT(std::sqrt(calibration.offset->cov_mm2(0, 0)), 0.002) << order;
    EXPECT_THAT(calibration.text, HasSubstr("from 9 holes in 36 looks")) << order;
  }
}

TEST(JobCalibration, TakesRowsOnlyWhereTheProgramSaysNoPlace) {
  const TemporaryFolder folder;
  const MachineConfig config = machine_with_coupon(folder);
  run_simulated(excellon("G39X300.0Y100.0\nT1\nG38X360.0Y150.0\n"), config);
  EXPECT_EQ(used_rows(config)->count(), 0);
  run_simulated(excellon("G39\nT1\nG38X360.0Y150.0\n"), config);
  EXPECT_EQ(used_rows(config)->count(), 3);
}

/// The calibration's error of the axis is in the offset and in every target, with opposite signs.
TEST(JobCalibration, HidesAWrongAxisOfTheCamera) {
  const TemporaryFolder folder;
  const MachineConfig config =
      machine_with_coupon(folder, "[sim.camera]\naxis_px = [122.5, 106.5]\n");
  const Job job =
      run_simulated(excellon("T1\nG38X350.0Y150.0\nG39X300.0Y100.0\nG38X360.0Y150.0\n"), config);
  ASSERT_EQ(job.survey.measurements.size(), 2U) << test::all_text(job.log);
  const auto& [before, after] = std::pair(job.survey.measurements[0], job.survey.measurements[1]);
  EXPECT_LT(squared_score(after, job.survey.calibrations.at(0)), kMostSquare);
  // The axis' columns: 10 um a pixel before, next to nothing afterwards.
  ASSERT_TRUE(before.by_camera && after.by_camera);
  EXPECT_GT((before.by_camera->middleCols<2>(2)).norm(), 0.01);
  EXPECT_LT((after.by_camera->middleCols<2>(2)).norm(), 0.0003);
}

TEST(JobCalibration, ReplaysToTheBit) {
  const TemporaryFolder folder;
  const MachineConfig config = machine_with_coupon(folder);
  const Program program = test::program_of(
      excellon("G35X350.0Y150.0\nT1\nX1.0Y1.0\nG39X400.0Y100.0\nG35X350.0Y150.0\nX1.0Y1.0\n"
               "$uvis,calib\nG38X360.0Y150.0\n"));
  auto machine = SimMachine::create(config, program);
  ASSERT_TRUE(machine) << machine.error().text();
  const Job first = run(program, config, *machine);
  ASSERT_EQ(first.holes.size(), 3U) << test::all_text(first.log);
  const std::string lines = measurement_lines(first.survey);

  auto recorded = parse_measurements(lines, "m.jsonl");
  ASSERT_TRUE(recorded) << recorded.error().text();
  MeasurementFileSource source(std::move(recorded).value());
  const Job second = run(program, config, source);
  EXPECT_TRUE(source.check_all_used());
  EXPECT_EQ(test::all_text(second.log), "");
  EXPECT_EQ(measurement_lines(second.survey), lines);
  ASSERT_EQ(second.holes.size(), first.holes.size());
  for (std::size_t i = 0; i < first.holes.size(); ++i) {
    EXPECT_EQ(second.holes[i].drill.actual, first.holes[i].drill.actual);
    EXPECT_EQ(second.holes[i].drill.cov_mm2, first.holes[i].drill.cov_mm2);
  }
}

/// Panel and coupon are seen by one camera, 22 um off that of the warm machine. The job learns that
/// as well as its covariance says: the mean error of 24 jobs is 0 to within 4 sigmas.
TEST(JobCalibration, IsUnbiasedOnAColdMachine) {
  constexpr int kTrials = 24;
  const TemporaryFolder folder;
  auto config = test::coupon_machine(folder.path(), R"([sim.coupon]
drill_wander_um = 3
stage_repeatability_um = 1
cold_um = [-20, 10]
warm_up_s = 36000
[coupon]
origin_mm = [300, 100]
rows_per_run = 3
approaches = ["+x+y"]
)");
  ASSERT_TRUE(config) << config.error().text();
  const std::string text = excellon("G39X300.0Y100.0\nT1\nG38X350.0Y150.0\n");
  Eigen::Vector2d sum_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d variance_mm2 = Eigen::Vector2d::Zero();
  for (int i = 0; i < kTrials; ++i) {
    config->sim->seed = static_cast<std::uint64_t>(i);
    config->sim->coupon.seed = 4000 + static_cast<std::uint64_t>(i);
    const Job job = run_simulated(text, *config);
    ASSERT_EQ(job.survey.measurements.size(), 1U) << "trial " << i << test::all_text(job.log);
    const Measurement& m = job.survey.measurements[0];
    sum_mm += error_mm(m);
    variance_mm2 += (m.measured.cov + job.survey.calibrations.at(0).offset->cov_mm2).diagonal();
  }
  for (const int axis : {0, 1}) {
    const double sigma_mm = std::sqrt(variance_mm2[axis] / kTrials);
    EXPECT_TRUE(test::mean_agrees(sum_mm[axis] / kTrials, 0, sigma_mm, kTrials));
  }
}

/// 1.5 mm below its focus the camera sees the coupon with a blur of 20 pixels.
TEST(JobCalibration, LooksWithTheFocusThatTheProgramFound) {
  const TemporaryFolder folder;
  MachineConfig config = machine_with_coupon(folder, "focus_z_mm = 1.5\nfocus_depth_mm = 0.05\n");
  config.vision.focus_range = FocusRange{mm(1), mm(2)};
  config.walk.has_focus = true;
  const Job job = run_simulated(
      excellon("$uvis,focus,x350.0y150.0\n$uvis,calib\nT1\nG38X350.0Y150.0\n"), config);
  ASSERT_EQ(job.survey.focus.size(), 1U) << test::all_text(job.log);
  ASSERT_TRUE(job.survey.focus[0].is_found) << job.survey.focus[0].reason;
  ASSERT_EQ(job.survey.measurements.size(), 1U) << test::all_text(job.log);
  ASSERT_EQ(job.survey.calibrations.size(), 1U);
  EXPECT_THAT(job.survey.calibrations[0].text, HasSubstr("from 9 holes in 36 looks"));
  EXPECT_LT(squared_score(job.survey.measurements[0], job.survey.calibrations[0]), kMostSquare);
}

TEST(JobCalibration, AtAZoomNeedsItsCamera) {
  const TemporaryFolder folder;
  const MachineConfig config = machine_with_coupon(folder);
  const Job job = run_simulated(excellon("$uvis,zoom,3\n$uvis,calib\n$uvis,zoom,1\nT1\n"), config);
  EXPECT_THAT(test::all_text(job.log),
              AllOf(HasSubstr("error[config-value]"), HasSubstr("zoom 3")));
}

/// Each zoom has an axis of its own, some way from that of the others.
TEST(JobCalibration, HoldsAtItsZoomOnly) {
  const TemporaryFolder folder;
  MachineConfig config = machine_with_coupon(folder);
  config.zooms.emplace(3, *config.camera);
  config.walk.uncertainty.zooms.emplace(3, config.walk.uncertainty.camera);
  const Job job = run_simulated(
      excellon("$uvis,zoom,3\nG39X300.0Y100.0\nT1\nG38X350.0Y150.0\n$uvis,zoom,1\n"), config);
  EXPECT_EQ(job.survey.measurements.size(), 1U) << test::all_text(job.log);

  JobCalibration calibration(config);
  SimCoupon machine = *SimCoupon::create(config, test::usual_scatter(3));
  CalibrationOrder order;
  order.line = 9;
  order.command = "G39";
  order.first_hole = position_mm<frame::Machine>(300, 100);
  order.zoom = 3;
  const auto answer = calibration.calibrate(order, {machine, machine, machine, {}, {}, {}});
  ASSERT_TRUE(answer) << answer.error().text();
  Measurement seen;
  seen.request.command = "G38";
  EXPECT_THAT(calibration.complete(seen),
              FailsWith(Code::CommandMisplaced, "calibration 0 (G39, line 9)"));
  seen.request.settings.zoom = 3;
  EXPECT_TRUE(calibration.complete(seen));
}

TEST(JobCalibration, RefusesWhatMovedTooFarOrIsTooUnsure) {
  const TemporaryFolder folder;
  MachineConfig config = machine_with_coupon(folder);
  config.nightly.emplace();
  config.nightly->limits.change = 0.030;  // the offset is 36 um off
  const std::string program = excellon("G39X300.0Y100.0\nT1\nG38X360.0Y150.0\n");
  EXPECT_THAT(test::all_text(run_simulated(program, config).log),
              testing::AllOf(HasSubstr("error[calibration-refused]"), HasSubstr("limit 30.0 um")));
  config.nightly->limits.change = 0.050;
  config.nightly->limits.sigma = 0.0002;  // nine holes of 3 um are known to 1 um
  EXPECT_THAT(test::all_text(run_simulated(program, config).log),
              HasSubstr("error[calibration-refused]"));
}

TEST(JobCalibration, RefusesPlacesThatWereDrilledBefore) {
  const TemporaryFolder folder;
  const MachineConfig config = machine_with_coupon(folder);
  const Job job = run_simulated(
      excellon("G39X300.0Y100.0\nT1\nG38X350.0Y150.0\nG39X300.0Y100.0\nG38X360.0Y150.0\n"), config);
  EXPECT_EQ(job.survey.calibrations.size(), 1U);
  EXPECT_THAT(test::all_text(job.log), HasSubstr("error[calibration-refused]"));
}

/// Another zoom is another look at the same coupon.
TEST(JobCalibration, RefusesPlacesThatWereDrilledBeforeAtAnotherZoom) {
  const TemporaryFolder folder;
  MachineConfig config = machine_with_coupon(folder);
  for (const double level : {1, 3}) {
    config.zooms.emplace(level, *config.camera);
    config.walk.uncertainty.zooms.emplace(level, config.walk.uncertainty.camera);
  }
  const Job job = run_simulated(excellon("$uvis,zoom,3\nG39X300.0Y100.0\n$uvis,zoom,1\n"
                                         "G39X300.0Y100.0\nT1\nG38X350.0Y150.0\n"),
                                config);
  EXPECT_EQ(job.survey.calibrations.size(), 1U);
  EXPECT_THAT(test::all_text(job.log), HasSubstr("error[calibration-refused]"));
  EXPECT_THAT(test::all_text(job.log), HasSubstr("the place was drilled at before"));
}

TEST(JobCalibration, RefusesPlacesThatTheMachineCannotReach) {
  const TemporaryFolder folder;
  const MachineConfig config = machine_with_coupon(folder);
  const Job job = run_simulated(excellon("G39X595.0Y100.0\nT1\nG38X360.0Y150.0\n"), config);
  EXPECT_THAT(test::all_text(job.log), HasSubstr("error[travel-exceeded]"));
  EXPECT_THAT(test::all_text(job.log), HasSubstr("calibration 0 (G39, line 9)"));
  EXPECT_TRUE(job.survey.measurements.empty());
}

// --- SIEB & MEYER --------------------------------------------------------------------------------

Job run_sieb_meyer(std::string_view body, const MachineConfig& config) {
  return run_simulated("%%5000\n" + std::string(body) + "$\nT1D1.\n$\n", config);
}

/// A hole that lies where it is programmed is seen 30 and 20 um off: G39,SPOP takes that over.
TEST(StoredOffset, MakesLaterMeasurementsRight) {
  const TemporaryFolder folder;
  const MachineConfig config = machine_with_coupon(folder);
  for (const char* order : {"G39,SPOP", "G39,SPOP1", "G39,SPOF1", "G39,SPOP\nG39,SPOF1"}) {
    const Job job = run_sieb_meyer(
        "X350.Y150.G32\n" + std::string(order) + "\nX360.Y150.G32\nG31\nX370.Y150.T1\nG30\n",
        config);
    const auto text = test::all_text(job.log);
    ASSERT_EQ(job.survey.measurements.size(), 2U) << text;
    EXPECT_NEAR(error_mm(job.survey.measurements[0]).x(), -0.03, kLocated.in_mm()) << text;
    EXPECT_LT(error_mm(job.survey.measurements[1]).norm(), kLocated.in_mm()) << order;
    EXPECT_THAT(job.survey.calibrations.at(0).text,
                StartsWith("1 spindle-camera offset(s) corrected by ("));
  }
}

/// Holes that the job has drilled are where the spindle was, wherever the panel lies: 40 offsets
/// that G39,SPOP learns from four of them each are off by what wander of the drill explains.
TEST(StoredOffset, IsUnbiasedByWhereThePanelLies) {
  constexpr int kTrials = 40;
  constexpr double kWander_mm = 0.003;
  const TemporaryFolder folder;
  auto config = test::coupon_machine(folder.path(), R"(panel_offset_mm = [0.1, -0.06]
panel_rotation_mrad = 0.3
stretch_ppm = [200, -100]
[sim.coupon]
drill_wander_um = 3
[uncertainty]
drill_wander_um = 3
stage_repeatability_um = 0
table_residual_um = 0
)");
  ASSERT_TRUE(config) << config.error().text();
  const Eigen::Vector2d true_mm = config->sim->spindle_camera_offset->in_mm();
  Eigen::Vector2d sum_mm = Eigen::Vector2d::Zero();
  double sum_square = 0;
  for (int i = 0; i < kTrials; ++i) {
    config->sim->seed = static_cast<std::uint64_t>(i);
    const Job job = run_sieb_meyer(
        "X350.Y150.T1\nX360.Y150.\nX350.Y160.\nX360.Y160.\nX355.Y155.\n"
        "X350.Y150.G32\nX360.Y150.G32\nX350.Y160.G32\nX360.Y160.G32\nG39,SPOP\nG34\n"
        "X355.Y155.G32\nG31\nX370.Y150.T1\nG30\n",
        *config);
    const auto text = test::all_text(job.log);
    ASSERT_EQ(job.survey.measurements.size(), 5U) << "trial " << i << text;
    ASSERT_EQ(job.survey.calibrations.size(), 1U) << "trial " << i << text;
    const SpindleCameraOffset& learned = *job.survey.calibrations[0].offset;
    const Eigen::Vector2d off_mm = learned.offset.in_mm() - true_mm;
    sum_mm += off_mm;
    sum_square += off_mm.dot(learned.cov_mm2.inverse() * off_mm);
    // The fifth hole is seen where it was drilled but for its own wander and that of the four.
    EXPECT_LT(error_mm(job.survey.measurements[4]).norm(), 6 * kWander_mm) << "trial " << i;
  }
  for (const double mean_mm : {sum_mm.x() / kTrials, sum_mm.y() / kTrials}) {
    EXPECT_TRUE(test::mean_agrees(mean_mm, 0, kWander_mm / 2, kTrials));
  }
  // Holes that scatter more than usual enlarge the covariance, so that this is below 2.
  EXPECT_LT(sum_square / kTrials, 2 * (1 + 4 / std::sqrt(kTrials)));
  EXPECT_GT(sum_square / kTrials, 1);
}

/// The coupon's holes are on the same machine: a target at one is that hole.
TEST(JobCalibration, SeesTheHolesOfItsCouponWhereTheyWereDrilled) {
  const TemporaryFolder folder;
  const MachineConfig config = machine_with_coupon(folder, "panel_offset_mm = [0.2, 0.1]\n");
  const Job job =
      run_simulated(excellon("G39X300.0Y100.0\nT1\nG38X300.0Y100.0\nG38X350.0Y150.0\n"), config);
  ASSERT_EQ(job.survey.measurements.size(), 2U) << test::all_text(job.log);
  // 3 um of wander, 1 of the stage, and 1 of the offset that was found.
  EXPECT_LT(error_mm(job.survey.measurements[0]).norm(), 0.015);
  EXPECT_NEAR(error_mm(job.survey.measurements[1]).x(), 0.2, 0.005);
}

TEST(StoredOffset, OfAnotherStationMovesNothingHere) {
  const TemporaryFolder folder;
  const MachineConfig config = machine_with_coupon(folder);
  for (const char* order : {"G39,SPOP2", "G39,SPOF2", "G39,SPISPI"}) {
    const Job job = run_sieb_meyer(
        "X350.Y150.G32\n" + std::string(order) + "\nX360.Y150.G32\nG31\nX370.Y150.T1\nG30\n",
        config);
    ASSERT_EQ(job.survey.measurements.size(), 2U);
    EXPECT_NEAR(error_mm(job.survey.measurements[1]).x(), -0.03, kLocated.in_mm()) << order;
    EXPECT_TRUE(job.survey.calibrations.empty());
    EXPECT_THAT(test::all_text(job.log), HasSubstr("warning[calibration-not-performed]")) << order;
  }
}

CalibrationOrder correction(OffsetOrder::Of of, int number, double x_mm) {
  CalibrationOrder order;
  order.correction.emplace();
  order.correction->order = {of, number};
  order.correction->deviation = displacement_mm<frame::Machine>(x_mm, 0);
  order.correction->cov_mm2 = 1e-6 * Eigen::Matrix2d::Identity();
  return order;
}

TEST(StoredOffset, OfTwoStationsAndSpindles) {
  const TemporaryFolder folder;
  MachineConfig config = machine_with_coupon(folder);
  const SpindleCameraOffset offset{displacement_mm<frame::Machine>(45, -3),
                                   1e-6 * Eigen::Matrix2d::Identity()};
  for (const SpindleAt at : {SpindleAt{1, 1}, SpindleAt{2, 1}, SpindleAt{1, 2}}) {
    ASSERT_TRUE(config.spindle_setting.calibration.offsets.set(at, offset));
  }
  JobCalibration job(config);
  Measurement seen;
  ASSERT_TRUE(job.complete(seen));
  const auto to_other = job.correct(correction(OffsetOrder::Of::Station, 2, 0.01));
  ASSERT_TRUE(to_other && *to_other);
  const CalibrationAnswer* const other = &**to_other;
  EXPECT_FALSE(other->offset);  // spindle 1 drills at station 1
  EXPECT_THAT(other->text, HasSubstr("spindle 1 at station 1"));
  EXPECT_EQ(job.offset().offset, config.spindle_camera.offset);
  // Both orders take the same measurement: they do not add up.
  ASSERT_TRUE(job.correct(correction(OffsetOrder::Of::Station, 1, 0.01)));
  const auto mine = job.correct(correction(OffsetOrder::Of::Spindle, 1, 0.01));
  ASSERT_TRUE(mine && *mine && (*mine)->offset);
  EXPECT_NEAR(job.offset().offset.in_mm().x(), 44.99, 1e-12);
  // Another one, made with the new offset, does.
  ASSERT_TRUE(job.complete(seen));
  ASSERT_TRUE(job.correct(correction(OffsetOrder::Of::Station, 1, 0.01)));
  EXPECT_NEAR(job.offset().offset.in_mm().x(), 44.98, 1e-12);
  // Farther than the usual 50 um: what was seen is not that hole.
  EXPECT_THAT(job.correct(correction(OffsetOrder::Of::Station, 1, 0.06)),
              FailsWith(Code::CalibrationRefused, "limit 50.0 um"));
  EXPECT_NEAR(job.offset().offset.in_mm().x(), 44.98, 1e-12);
}

// --- devices -------------------------------------------------------------------------------------

/// One virtual machine behind the owners that a source wants.
class SharedStage final : public Stage {
 public:
  SharedStage(SimCoupon& machine, double growth) : machine_(machine), growth_(growth) {}
  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    // A table that grows about the coupon between drilling and looking.
    const double factor = machine_.holes().size() >= 9 ? growth_ : 1;
    const Eigen::Vector2d middle_mm(305, 105);
    const Eigen::Vector2d stands_mm = middle_mm + factor * (spindle.in_mm() - middle_mm);
    PANELCAL_CHECK(machine_.move_to(position_mm<frame::Machine>(stands_mm)));
    return spindle;
  }

 private:
  SimCoupon& machine_;
  double growth_;
};

/// A camera with a focus axis.
class SharedCamera final : public CameraDevice {
 public:
  SharedCamera(SimCoupon& machine, std::optional<double>& focus_mm)
      : machine_(machine), focus_mm_(focus_mm) {}
  bool can_set(CameraSetting setting) const override { return setting == CameraSetting::Focus; }
  Expected<void> set(CameraSetting setting, double value) override {
    focus_mm_ = value;
    return machine_.set(setting, value);
  }
  Expected<Image> take() override { return machine_.take(); }
  std::string name() const override { return "shared"; }

 private:
  SimCoupon& machine_;
  std::optional<double>& focus_mm_;
};

class SharedSpindle final : public Spindle {
 public:
  SharedSpindle(SimCoupon& machine, bool can) : machine_(machine), can_(can) {}
  bool can_drill() const override { return can_; }
  Expected<void> drill(int tool) override { return machine_.drill(tool); }

 private:
  SimCoupon& machine_;
  bool can_;
};

class LiveSourceTest : public ::testing::Test {
 protected:
  LiveSource source(Prompt prompt = {}, bool can_drill = true, double growth = 1) {
    auto views = std::make_unique<CameraViews>(config_.spindle_camera,
                                               std::make_unique<SharedCamera>(machine_, focus_mm_),
                                               std::make_unique<SharedStage>(machine_, growth),
                                               config_.settle,
                                               [](Time) {});
    views->set_stated(config_.vision);
    auto made = LiveSource::create(config_,
                                   std::move(views),
                                   std::make_unique<SharedSpindle>(machine_, can_drill),
                                   std::move(prompt));
    EXPECT_TRUE(made) << made.error().text();
    return std::move(made).value();
  }
  static CalibrationOrder order() {
    CalibrationOrder order;
    order.line = 7;
    order.command = "G39";
    order.first_hole = position_mm<frame::Machine>(300, 100);
    return order;
  }
  /// Looks at a hole that the spindle drilled where it was sent.
  static Measurement look(LiveSource& source) {
    MeasurementRequest request;
    request.settings.tools = {1};
    request.nominal = position_mm<frame::Nominal>(400, 200);
    request.expected = position_mm<frame::Actual>(400, 200);
    const auto seen = source.measure(request);
    EXPECT_TRUE(seen) << seen.error().text();
    EXPECT_EQ(seen->status, MeasurementStatus::Found) << seen->reason;
    return *seen;
  }

  TemporaryFolder folder_;
  MachineConfig config_ = machine_with_coupon(folder_);
  SimCoupon machine_ = *SimCoupon::create(config_, test::usual_scatter(3));
  std::optional<double> focus_mm_;  ///< to which the camera was told to go last
};

TEST_F(LiveSourceTest, LooksThroughTheNewOffset) {
  LiveSource source = this->source();
  ASSERT_TRUE(machine_.move_to(position_mm<frame::Machine>(400, 200)));
  ASSERT_TRUE(machine_.drill(1));
  const Eigen::Vector2d hole_mm = machine_.holes().at(0).in_mm();
  const auto off_mm = [&](const Measurement& m) -> Eigen::Vector2d {
    return m.measured.position.in_mm() - hole_mm;
  };
  // Besides the stage's own 1 um.
  constexpr double kLook_mm = 0.005;
  EXPECT_NEAR(off_mm(look(source)).x(), -0.03, kLook_mm);
  const auto answer = source.calibrate(order());
  ASSERT_TRUE(answer) << answer.error().text();
  ASSERT_TRUE(*answer);
  EXPECT_LT(off_mm(look(source)).norm(), kLook_mm);
  EXPECT_EQ(machine_.holes().size(), 10U);
}

TEST_F(LiveSourceTest, LooksAtTheCouponWithTheFocusThatTheProgramFound) {
  config_.sim->focus_z = mm(1.5);
  config_.vision.focus_range = FocusRange{mm(1), mm(2)};
  config_.vision.focus = mm(1.1);  // for a program that does not focus
  machine_ = *SimCoupon::create(config_, test::usual_scatter(3));
  ASSERT_TRUE(machine_.move_to(position_mm<frame::Machine>(400, 200)));
  ASSERT_TRUE(machine_.drill(1));
  LiveSource source = this->source();
  MeasurementRequest request;
  request.seq = -1;
  request.expected = position_mm<frame::Actual>(400, 200);
  const auto focus = source.focus(request);
  ASSERT_TRUE(focus) << focus.error().text();
  ASSERT_TRUE((*focus)->is_found) << (*focus)->reason;
  const auto answer = source.calibrate(order());
  ASSERT_TRUE(answer) << answer.error().text();
  EXPECT_EQ(focus_mm_, (*focus)->z.in_mm());
}

TEST_F(LiveSourceTest, AsksForTheEntryMaterial) {
  config_.coupon->has_entry_material = true;
  std::vector<std::string> asked;
  LiveSource source = this->source([&](std::string_view what) -> Expected<void> {
    asked.emplace_back(what);
    return {};
  });
  ASSERT_TRUE(source.calibrate(order()));
  EXPECT_THAT(asked,
              testing::ElementsAre("lay entry material on the coupon",
                                   "take the entry material off the coupon"));
}

TEST_F(LiveSourceTest, WithoutADrillNobodyCalibrates) {
  LiveSource source = this->source({}, false);
  const auto answer = source.calibrate(order());
  ASSERT_TRUE(answer);
  EXPECT_FALSE(*answer);
  EXPECT_TRUE(machine_.holes().empty());
}

TEST_F(LiveSourceTest, RefusesACouponThatMovedBetweenDrillingAndLooking) {
  LiveSource source = this->source({}, true, 1.003);
  const auto answer = source.calibrate(order());
  EXPECT_THAT(answer, FailsWith(Code::CalibrationRefused, "calibration 0 (G39, line 7)"));
}

// --- recorded ------------------------------------------------------------------------------------

constexpr std::string_view kRecorded =
    R"({"calibration":0,"line":7,"command":"G39","path":[],"first_hole":[101,202],"offset":[45,-3],)"
    R"("cov":[2e-06,0,2e-06],"text":"found"})";

std::string with(std::string_view piece, std::string_view other) {
  std::string text(kRecorded);
  const auto at = text.find(piece);
  EXPECT_NE(at, std::string::npos) << piece;
  return text.replace(at, piece.size(), other);
}

TEST(RecordedCalibration, ReadsBackWhatWasWritten) {
  const auto recorded = parse_measurements(kRecorded, "m.jsonl");
  ASSERT_TRUE(recorded) << recorded.error().text();
  ASSERT_EQ(recorded->calibrations.size(), 1U);
  EXPECT_EQ(to_json(recorded->calibrations[0].answer), kRecorded);
}

TEST(RecordedCalibration, RefusesWhatIsNone) {
  const auto refuses = [](const std::string& text, Code code, const std::string& part) {
    EXPECT_THAT(parse_measurements(text, "m.jsonl"), FailsWith(code, part)) << text;
  };
  refuses(with("\"offset\":[45,-3],", ""), Code::MeasurementFile, "m.jsonl:1:");
  refuses(with("2e-06,0", "-2e-06,0"), Code::MeasurementInvalid, "m.jsonl:1:");
  refuses(with("2e-06,0", "2e-06,3e-06"), Code::MeasurementInvalid, "xy^2 <= xx yy");
  refuses(with("[45,", "[1e300,"), Code::MeasurementFile, "1000000 mm");
  refuses(with("\"calibration\":0", "\"calibration\":-1"), Code::MeasurementFile, "m.jsonl:1:");
  refuses(with("\"text\"", "\"txet\""), Code::MeasurementFile, "text");
  refuses(
      std::string(kRecorded) + "\n" + std::string(kRecorded), Code::MeasurementFile, "m.jsonl:2:");
}

TEST(RecordedCalibration, ReplaysAStoredPatternFromAnotherFolder) {
  CalibrationAnswer written = parse_measurements(kRecorded, "m.jsonl")->calibrations[0].answer;
  written.order.file = "job/PINS";
  written.order.file_sha256 = sha256("G39\n");
  const auto recorded = parse_measurements(to_json(written), "m.jsonl");
  ASSERT_TRUE(recorded) << recorded.error().text();
  CalibrationOrder order = written.order;
  order.file = "PINS";
  EXPECT_TRUE(MeasurementFileSource(*recorded).calibrate(order));
  order.file_sha256 = sha256("G39\n\n");
  EXPECT_THAT(MeasurementFileSource(*recorded).calibrate(order),
              FailsWith(Code::MeasurementMismatch, "file \"PINS\", sha256 "));
}

TEST(RecordedCalibration, HasToBeTheProgramsOwn) {
  CalibrationOrder order;
  order.line = 7;
  order.command = "G39";
  order.first_hole = position_mm<frame::Machine>(101, 202);
  const auto answer_of = [&](const std::string& text) {
    MeasurementFileSource source(parse_measurements(text, "m.jsonl").value());
    return source.calibrate(order);
  };
  ASSERT_TRUE(answer_of(std::string(kRecorded)));
  EXPECT_TRUE(*answer_of(std::string(kRecorded)));
  EXPECT_THAT(answer_of(with("\"line\":7", "\"line\":8")),
              FailsWith(Code::MeasurementMismatch, "line 8"));
  EXPECT_THAT(answer_of(with("[101,202]", "[101,203]")),
              FailsWith(Code::MeasurementMismatch, "[101, 203]"));
  EXPECT_THAT(answer_of(with("\"first_hole\":[101,202],", "")),
              FailsWith(Code::MeasurementMismatch));
  // Of another number: this one was passed on only.
  EXPECT_FALSE(*answer_of(with("\"calibration\":0", "\"calibration\":1")));
  MeasurementFileSource unused(parse_measurements(kRecorded, "m.jsonl").value());
  EXPECT_THAT(unused.check_all_used(), FailsWith(Code::MeasurementMismatch, "calibration 0"));
}

}  // namespace
}  // namespace panelcal
