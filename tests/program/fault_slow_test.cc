// SPDX-License-Identifier: Apache-2.0
// The table of tests/bench/README.md ("Faults"), held against its bounds.
#include <gtest/gtest.h>

#include "tests/calib/faults/binomial.h"
#include "tests/program/fault_trial.h"

namespace panelcal {
namespace {

constexpr int kManyJobs = 5000;

class ManyJobs : public testing::TestWithParam<std::uint64_t> {
 protected:
  static int most_by_chance() { return test::binomial_quantile(0.99, kManyJobs, 1e-3); }
};

TEST_P(ManyJobs, WithFaultsAreNotReleasedWithASmallRisk) {
  const auto r = test::run({.n_jobs = kManyJobs, .seed = GetParam(), .n_faults_most = 3});
  EXPECT_LE(r.n_broken_sure, most_by_chance());
  EXPECT_GT(r.n_sure, kManyJobs / 100);
}

TEST_P(ManyJobs, WithoutFaultsAreHeldAsSeldomAsStated) {
  const auto r = test::run({.n_jobs = kManyJobs, .seed = GetParam()});
  EXPECT_LE(r.n_gated, most_by_chance());
  EXPECT_GE(r.coverage(), 0.94);
  EXPECT_LE(r.coverage(), 0.96);
}

TEST_P(ManyJobs, HoldTheTruthThoughTheNoiseIsStatedWrong) {
  for (const double factor : {0.5, 2.0}) {
    for (const int n_targets_most : {6, 12}) {
      const auto r = test::run({.n_jobs = kManyJobs,
                                .seed = GetParam(),
                                .noise_factor = factor,
                                .n_targets_least = 6,
                                .n_targets_most = n_targets_most,
                                .nested_share = 0});
      EXPECT_GE(r.coverage(), 0.9) << factor << " times, 6 to " << n_targets_most << " targets";
    }
  }
}

TEST_P(ManyJobs, WithOneFaultOfAnyKindAreNotReleasedWithASmallRisk) {
  for (int i = 0; i < test::kRandomFaults; ++i) {
    const auto fault = static_cast<test::JobFault>(i);
    const auto r = test::run({.n_jobs = kManyJobs, .seed = GetParam(), .only = fault});
    EXPECT_LE(r.n_broken_sure, most_by_chance()) << test::name(fault);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, ManyJobs, testing::Values(20261126, 1, 2));

}  // namespace
}  // namespace panelcal
