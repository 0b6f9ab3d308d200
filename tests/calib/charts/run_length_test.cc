// SPDX-License-Identifier: Apache-2.0
#include "calib/charts/run_length.h"

#include <cmath>

#include "calib/base/statistics/chi_square.h"
#include "calib/base/statistics/distributions.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

// Lucas and Saccucci 1990: limits to three decimals for a run length of 500.
TEST(RunLength, OfOneAverageIsAsPublished) {
  EXPECT_NEAR(ewma_run_length(1, 0.10, 2.814), 500, 2);
  EXPECT_NEAR(ewma_run_length(1, 0.25, 2.998), 500, 2);
  EXPECT_NEAR(ewma_run_length(1, 0.50, 3.071), 500, 2);
}

// Montgomery, Introduction to Statistical Quality Control, 9.1: two-sided, allowance 0.5; 168 and
// 465 nights. One-sided ones run twice as long.
TEST(RunLength, OfSumsIsAsPublished) {
  EXPECT_NEAR(cusum_run_length(0.5, 4), 2 * 168, 2);
  EXPECT_NEAR(cusum_run_length(0.5, 5), 2 * 465, 2);
}

TEST(RunLength, OfEachNightByItselfIsThatOfItsTail) {
  for (int n_axes = 1; n_axes <= 4; ++n_axes) {
    EXPECT_NEAR(ewma_run_length(n_axes, 1, 3.5) * chi_square_exceedance(3.5 * 3.5, n_axes), 1, 1e-6)
        << n_axes;
  }
}

TEST(RunLength, OfASumWithoutLimitIsThatOfTheFirstStepUp) {
  EXPECT_NEAR(cusum_run_length(1.0, 1e-9) * normal_exceedance(1.0), 1, 1e-6);
}

TEST(RunLength, LimitsAreItsInverse) {
  for (const double nights : {50.0, 1000.0, 100000.0}) {
    EXPECT_NEAR(ewma_run_length(2, 0.2, ewma_limit(2, 0.2, nights)) / nights, 1, 1e-5);
    EXPECT_NEAR(ewma_run_length(3, 0.05, ewma_limit(3, 0.05, nights)) / nights, 1, 1e-5);
    EXPECT_NEAR(cusum_run_length(0.25, cusum_limit(0.25, nights)) / nights, 1, 1e-5);
  }
}

}  // namespace
}  // namespace panelcal
