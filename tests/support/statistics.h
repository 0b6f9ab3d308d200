// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <gtest/gtest.h>

namespace panelcal::test {

/// Greatest distance of a statistic from its expectation, in its own standard deviations. With
/// fixed seeds a test either always passes or never does; 4 leaves one in 16,000 to bad luck when a
/// seed is chosen.
inline constexpr double kStatisticalLimit = 4.0;

/// A sum of chi squares agrees with its degrees of freedom. The sum is nearly normal for the many
/// degrees of freedom used here, with variance 2 dof.
inline ::testing::AssertionResult chi_square_agrees(double sum, int dof) {
  const double per_dof = sum / dof;
  const double bound = kStatisticalLimit * std::sqrt(2.0 / dof);
  if (std::abs(per_dof - 1) <= bound) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << "chi square per d.o.f. is " << per_dof << " over " << dof << ", limit 1 +- " << bound;
}

/// A mean of n draws with the standard deviation sigma agrees with `expected`.
inline ::testing::AssertionResult mean_agrees(double mean, double expected, double sigma, int n) {
  const double bound = kStatisticalLimit * sigma / std::sqrt(static_cast<double>(n));
  if (std::abs(mean - expected) <= bound) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << "mean of " << n << " draws is " << mean << ", expected " << expected << " +- " << bound;
}

}  // namespace panelcal::test
