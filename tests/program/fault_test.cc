// SPDX-License-Identifier: Apache-2.0
// Is a small risk stated of jobs with a fault? Small samples; the whole is fault_slow_test.cc.
#include <gtest/gtest.h>

#include "tests/calib/faults/binomial.h"
#include "tests/program/fault_trial.h"

namespace panelcal {
namespace {

constexpr std::uint64_t kFaultSeed = 20261126;
constexpr int kFewJobs = 400;

/// The number that chance of 1 in 1,000 exceeds in 1 of 100 samples.
int most_by_chance(int n_jobs) {
  return test::binomial_quantile(0.99, n_jobs, 1e-3);
}

TEST(JobFaults, AreNotReleasedWithASmallRisk) {
  const test::FaultTrialResult faulty =
      test::run({.n_jobs = kFewJobs, .seed = kFaultSeed, .n_faults_most = 3});
  EXPECT_EQ(faulty.n_jobs, kFewJobs);
  EXPECT_GT(faulty.n_gated, kFewJobs / 2);
  EXPECT_GT(faulty.n_sure, 0);  // what is released is not all held back by words
  EXPECT_LE(faulty.n_broken_sure, most_by_chance(kFewJobs));
}

TEST(JobFaults, AreNotFoundWhereThereAreNone) {
  const test::FaultTrialResult healthy = test::run({.n_jobs = kFewJobs, .seed = kFaultSeed});
  EXPECT_LE(healthy.n_gated, most_by_chance(kFewJobs));
  EXPECT_LE(healthy.n_broken_sure, most_by_chance(kFewJobs));
  EXPECT_GT(healthy.n_sure, kFewJobs / 3);
}

TEST(JobFaults, LeaveNoSmallRiskToFewTargets) {
  for (const int n_targets : {1, 2, 3}) {
    const test::FaultTrialResult few = test::run({.n_jobs = kFewJobs / 4,
                                                  .seed = kFaultSeed,
                                                  .n_targets_least = n_targets,
                                                  .n_targets_most = n_targets,
                                                  .nested_share = 0});
    EXPECT_GT(few.n_released, kFewJobs / 8);
    EXPECT_GE(few.least_hole_told, 1e-3) << n_targets;
  }
}

TEST(JobFaults, AWarpUnderAFixedStretchIsHeld) {
  const test::FaultTrialResult warped = test::run({.n_jobs = kFewJobs / 4,
                                                   .seed = kFaultSeed,
                                                   .only = test::JobFault::Warped,
                                                   .n_targets_least = 6});
  EXPECT_EQ(warped.n_broken_sure, 0);
  EXPECT_EQ(warped.n_released, 0);
}

}  // namespace
}  // namespace panelcal
