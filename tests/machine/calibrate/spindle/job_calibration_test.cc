// SPDX-License-Identifier: Apache-2.0
// Programs that calibrate while they are measured, on the simulated machine.
#include "machine/calibrate/spindle/job_calibration.h"

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "machine/sim/sim_coupon.h"
#include "machine/sim/sim_machine.h"
#include "machine/sources/measurement_file_source.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/machine/calibrate/spindle/coupon_job_run.h"
#include "tests/support/matchers.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using test::error_mm;
using test::excellon_program;
using test::FailsWith;
using test::kLocated;
using test::kMostSquare;
using test::machine_with_coupon;
using test::run_job;
using test::run_simulated;
using test::SimulatedJob;
using test::squared_score;
using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;

TEST(JobCalibration, MakesLaterMeasurementsRight) {
  for (const char* order : {"G39X300.0Y100.0\n", "G39\n", "$uvis,calib\n"}) {
    const TemporaryFolder folder;
    const MachineConfig config = machine_with_coupon(folder);
    const SimulatedJob job = run_simulated(
        excellon_program("T1\nG38X350.0Y150.0\n" + std::string(order) + "G38X360.0Y150.0\n"),
        config);
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
  run_simulated(excellon_program("G39X300.0Y100.0\nT1\nG38X360.0Y150.0\n"), config);
  EXPECT_EQ(used_rows(config)->count(), 0);
  run_simulated(excellon_program("G39\nT1\nG38X360.0Y150.0\n"), config);
  EXPECT_EQ(used_rows(config)->count(), 3);
}

/// The calibration's error of the axis is in the offset and in every target, with opposite signs.
TEST(JobCalibration, HidesAWrongAxisOfTheCamera) {
  const TemporaryFolder folder;
  const MachineConfig config =
      machine_with_coupon(folder, "[sim.camera]\naxis_px = [122.5, 106.5]\n");
  const SimulatedJob job = run_simulated(
      excellon_program("T1\nG38X350.0Y150.0\nG39X300.0Y100.0\nG38X360.0Y150.0\n"), config);
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
      excellon_program("G35X350.0Y150.0\nT1\nX1.0Y1.0\nG39X400.0Y100.0\nG35X350.0Y150.0\nX1.0Y1.0\n"
                       "$uvis,calib\nG38X360.0Y150.0\n"));
  auto machine = SimMachine::create(config, program);
  ASSERT_TRUE(machine) << machine.error().text();
  const SimulatedJob first = run_job(program, config, *machine);
  ASSERT_EQ(first.holes.size(), 3U) << test::all_text(first.log);
  const std::string lines = measurement_lines(first.survey);

  auto recorded = parse_measurements(lines, "m.jsonl");
  ASSERT_TRUE(recorded) << recorded.error().text();
  MeasurementFileSource source(std::move(recorded).value());
  const SimulatedJob second = run_job(program, config, source);
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
/// as well as its covariance says: the mean error of 12 jobs is 0 to within 4 sigmas.
TEST(JobCalibration, IsUnbiasedOnAColdMachine) {
  constexpr int kTrials = 12;
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
  const std::string text = excellon_program("G39X300.0Y100.0\nT1\nG38X350.0Y150.0\n");
  Eigen::Vector2d sum_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d variance_mm2 = Eigen::Vector2d::Zero();
  for (int i = 0; i < kTrials; ++i) {
    config->sim->seed = static_cast<std::uint64_t>(i);
    config->sim->coupon.seed = 4000 + static_cast<std::uint64_t>(i);
    const SimulatedJob job = run_simulated(text, *config);
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
  const SimulatedJob job = run_simulated(
      excellon_program("$uvis,focus,x350.0y150.0\n$uvis,calib\nT1\nG38X350.0Y150.0\n"), config);
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
  const SimulatedJob job =
      run_simulated(excellon_program("$uvis,zoom,3\n$uvis,calib\n$uvis,zoom,1\nT1\n"), config);
  EXPECT_THAT(test::all_text(job.log),
              AllOf(HasSubstr("error[config-value]"), HasSubstr("zoom 3")));
}

/// Each zoom has an axis of its own, some way from that of the others.
TEST(JobCalibration, HoldsAtItsZoomOnly) {
  const TemporaryFolder folder;
  MachineConfig config = machine_with_coupon(folder);
  config.zooms.emplace(3, *config.camera);
  config.walk.uncertainty.zooms.emplace(3, config.walk.uncertainty.camera);
  const SimulatedJob job = run_simulated(
      excellon_program("$uvis,zoom,3\nG39X300.0Y100.0\nT1\nG38X350.0Y150.0\n$uvis,zoom,1\n"),
      config);
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
  const std::string program = excellon_program("G39X300.0Y100.0\nT1\nG38X360.0Y150.0\n");
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
  const SimulatedJob job = run_simulated(
      excellon_program("G39X300.0Y100.0\nT1\nG38X350.0Y150.0\nG39X300.0Y100.0\nG38X360.0Y150.0\n"),
      config);
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
  const SimulatedJob job =
      run_simulated(excellon_program("$uvis,zoom,3\nG39X300.0Y100.0\n$uvis,zoom,1\n"
                                     "G39X300.0Y100.0\nT1\nG38X350.0Y150.0\n"),
                    config);
  EXPECT_EQ(job.survey.calibrations.size(), 1U);
  EXPECT_THAT(test::all_text(job.log), HasSubstr("error[calibration-refused]"));
  EXPECT_THAT(test::all_text(job.log), HasSubstr("the place was drilled at before"));
}

TEST(JobCalibration, RefusesPlacesThatTheMachineCannotReach) {
  const TemporaryFolder folder;
  const MachineConfig config = machine_with_coupon(folder);
  const SimulatedJob job =
      run_simulated(excellon_program("G39X595.0Y100.0\nT1\nG38X360.0Y150.0\n"), config);
  EXPECT_THAT(test::all_text(job.log), HasSubstr("error[travel-exceeded]"));
  EXPECT_THAT(test::all_text(job.log), HasSubstr("calibration 0 (G39, line 9)"));
  EXPECT_TRUE(job.survey.measurements.empty());
}

/// The coupon's holes are on the same machine: a target at one is that hole.
TEST(JobCalibration, SeesTheHolesOfItsCouponWhereTheyWereDrilled) {
  const TemporaryFolder folder;
  const MachineConfig config = machine_with_coupon(folder, "panel_offset_mm = [0.2, 0.1]\n");
  const SimulatedJob job = run_simulated(
      excellon_program("G39X300.0Y100.0\nT1\nG38X300.0Y100.0\nG38X350.0Y150.0\n"), config);
  ASSERT_EQ(job.survey.measurements.size(), 2U) << test::all_text(job.log);
  // 3 um of wander, 1 of the stage, and 1 of the offset that was found.
  EXPECT_LT(error_mm(job.survey.measurements[0]).norm(), 0.015);
  EXPECT_NEAR(error_mm(job.survey.measurements[1]).x(), 0.2, 0.005);
}

}  // namespace
}  // namespace panelcal
