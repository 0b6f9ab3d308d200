// SPDX-License-Identifier: Apache-2.0
#include <cstdint>

#include <gtest/gtest.h>

#include "tests/calib/simulated_faults.h"

// The table of tests/bench/README.md with fewer jobs, and bounds that fit their number.
namespace panelcal::test {
namespace {

constexpr std::uint64_t kSeed = 7;

class SimulatedFaults : public ::testing::TestWithParam<SimulatedFault> {};

/// 60 jobs: with 99 % named the chance of fewer than 56 is 0.03 %.
TEST_P(SimulatedFaults, AreNamed) {
  const Random all(kSeed);
  int n = 0;
  int n_named = 0;
  for (std::uint64_t i = 0; n < 60; ++i) {
    ASSERT_LT(i, 100'000U);
    Random random = all.fork(i);
    const auto job = draw_job(random, GetParam(), usual_settings());
    if (!job) continue;
    ++n;
    if (finding_of(*job, job->examine()) == Finding::Named) ++n_named;
  }
  EXPECT_GE(n_named, 56) << name(GetParam()) << ", seed " << kSeed;
}

INSTANTIATE_TEST_SUITE_P(EveryKind,
                         SimulatedFaults,
                         ::testing::Values(SimulatedFault::WrongPad,
                                           SimulatedFault::Damaged,
                                           SimulatedFault::OutOfFocus,
                                           SimulatedFault::QuarterSeen,
                                           SimulatedFault::HalfSeen,
                                           SimulatedFault::MirroredSeen,
                                           SimulatedFault::ScaleSeen,
                                           SimulatedFault::QuarterTaken,
                                           SimulatedFault::HalfTaken,
                                           SimulatedFault::MirroredTaken,
                                           SimulatedFault::ScaleTaken,
                                           SimulatedFault::Revision));

/// 4,000 healthy jobs at a stated rate of 1 %: 40 are accused, and 20 to 62 in 99.9 % of all tries.
TEST(HealthyJobs, AreAccusedAsOftenAsStated) {
  FaultSettings settings = usual_settings();
  const Random all(kSeed);
  int n_accused = 0;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    Random random = all.fork(i);
    auto job = draw_job(random, SimulatedFault::Healthy, settings);
    ASSERT_TRUE(job);
    // The test alone, not the other gates.
    job->limits = {};
    job->limits.false_alarm = 0.01;
    job->pads.clear();
    if (job->examine()) ++n_accused;
  }
  EXPECT_GE(n_accused, 20);
  EXPECT_LE(n_accused, 62);
}

}  // namespace
}  // namespace panelcal::test
