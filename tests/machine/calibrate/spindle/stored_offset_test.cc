// SPDX-License-Identifier: Apache-2.0
// G39,SPOP and its kin of SIEB & MEYER, on the simulated machine.
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "machine/calibrate/spindle/job_calibration.h"
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/machine/calibrate/spindle/coupon_job_run.h"
#include "tests/support/matchers.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using test::error_mm;
using test::FailsWith;
using test::kLocated;
using test::machine_with_coupon;
using test::run_simulated;
using test::SimulatedJob;
using test::TemporaryFolder;
using testing::HasSubstr;
using testing::StartsWith;

SimulatedJob run_sieb_meyer(std::string_view body, const MachineConfig& config) {
  return run_simulated("%%5000\n" + std::string(body) + "$\nT1D1.\n$\n", config);
}

/// A hole that lies where it is programmed is seen 30 and 20 um off: G39,SPOP takes that over.
TEST(StoredOffset, MakesLaterMeasurementsRight) {
  const TemporaryFolder folder;
  const MachineConfig config = machine_with_coupon(folder);
  for (const char* order : {"G39,SPOP", "G39,SPOP1", "G39,SPOF1", "G39,SPOP\nG39,SPOF1"}) {
    const SimulatedJob job = run_sieb_meyer(
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
    const SimulatedJob job = run_sieb_meyer(
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

TEST(StoredOffset, OfAnotherStationMovesNothingHere) {
  const TemporaryFolder folder;
  const MachineConfig config = machine_with_coupon(folder);
  for (const char* order : {"G39,SPOP2", "G39,SPOF2", "G39,SPISPI"}) {
    const SimulatedJob job = run_sieb_meyer(
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

}  // namespace
}  // namespace panelcal
