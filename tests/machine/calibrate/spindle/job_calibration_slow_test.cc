// SPDX-License-Identifier: Apache-2.0
// Uncertainty that a job states of what it measures behind its own calibration.
#include <cmath>
#include <cstdint>
#include <string>

#include "machine/sim/sim_machine.h"
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/machine/calibrate/spindle/coupon_job.h"
#include "tests/machine/virtual_machine.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

constexpr int kJobs = 400;
constexpr int kHoles = 12;

/// 12 holes of 3 um, each looked at once.
constexpr const char* kCoupon = R"([sim.coupon]
drill_wander_um = 3
stage_repeatability_um = 1
[coupon]
origin_mm = [300, 100]
columns = 4
rows_per_run = 3
approaches = ["+x+y"]
)";

/// The error of a hole at its own target against the covariance that the job gives it, over 400
/// jobs: its mean square is that of two standard normals.
TEST(JobCalibrationHonesty, HolesBehindACalibrationAreAsSureAsTheySay) {
  const test::TemporaryFolder folder;
  auto config = test::coupon_machine(folder.path(), kCoupon);
  ASSERT_TRUE(config) << config.error().text();
  const Program program = test::program_of(
      "M48\nMETRIC,TZ\nFMAT,2\nVER,1\nT1C0.8\n%\nG90\nG34,1\nG39X300.0Y100.0\nT1\n"
      "G38X350.0Y150.0\nM30\n");
  double sum = 0;
  int n_refused = 0;
  for (int i = 0; i < kJobs; ++i) {
    config->sim->seed = static_cast<std::uint64_t>(i);
    config->sim->coupon.seed = 7000 + static_cast<std::uint64_t>(i);
    auto machine = SimMachine::create(*config, program);
    ASSERT_TRUE(machine) << machine.error().text();
    DiagnosticLog log;
    const Survey survey = panelcal::survey(program, config->walk, *machine, log);
    // A sound coupon is refused now and then: by its outliers, or by its structure.
    if (log.has_errors()) {
      ASSERT_THAT(test::all_text(log), testing::HasSubstr("calibration-refused")) << "seed " << i;
      ++n_refused;
      continue;
    }
    test::HoleSink sink;
    execute(program, config->walk, survey, sink, log);
    ASSERT_EQ(sink.holes().size(), 1U);
    const Drill& drill = sink.holes()[0].drill;
    const Eigen::Vector2d error_mm = drill.actual.in_mm() - drill.nominal.in_mm();
    sum += error_mm.dot(drill.cov_mm2.inverse() * error_mm);
  }
  // The scatter is estimated with 22 degrees of freedom, and the covariance enlarged for that by 22
  // / 20: 2 F(2, 22) 20 / 22, of mean 2.
  constexpr double kFree = 2 * (kHoles - 1);
  const double variance_of_f = std::pow(kFree, 3) / (std::pow(kFree - 2, 2) * (kFree - 4));
  const double sigma = 2 * std::sqrt(variance_of_f) * (kFree - 2) / kFree;
  // Of 400 about 1.2, at 0.002 and 0.001 each.
  EXPECT_LE(n_refused, 5);
  const int n = kJobs - n_refused;
  RecordProperty("mean_square", std::to_string(sum / n / 2));
  EXPECT_TRUE(test::mean_agrees(sum / n, 2, sigma, n));
}

}  // namespace
}  // namespace panelcal
