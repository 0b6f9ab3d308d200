// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/chi_square.h"

#include <cmath>
#include <limits>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

// Abramowitz and Stegun 1964, table 26.8.
TEST(ChiSquare, IsAsTabulated) {
  EXPECT_NEAR(chi_square_exceedance(10.8276, 1), 1e-3, 1e-7);
  EXPECT_NEAR(chi_square_exceedance(13.8155, 2), 1e-3, 1e-7);
  EXPECT_NEAR(chi_square_exceedance(16.2662, 3), 1e-3, 1e-7);
  EXPECT_NEAR(chi_square_exceedance(4.35146, 5), 0.5, 1e-6);
  EXPECT_NEAR(chi_square_exceedance(59.7031, 30), 1e-3, 1e-7);
}

TEST(ChiSquare, GivesTheTabulatedLimits) {
  EXPECT_NEAR(chi_square_limit(1e-3, 1), 10.8276, 1e-4);
  EXPECT_NEAR(chi_square_limit(1e-3, 3), 16.2662, 1e-4);
  EXPECT_NEAR(chi_square_limit(0.5, 5), 4.35146, 1e-5);
}

// One degree of freedom: a normal variable beyond either end.
TEST(NoncentralChiSquare, IsANormalVariableSquared) {
  const auto above = [](double x) { return std::erfc(x / std::sqrt(2.0)) / 2; };
  for (const double shift : {0.0, 0.5, 3.0, 12.0}) {
    for (const double x : {0.1, 1.0, 3.29, 12.0}) {
      EXPECT_NEAR(noncentral_chi_square_exceedance(x * x, 1, shift * shift),
                  above(x - shift) + above(x + shift),
                  1e-12);
    }
  }
}

// Baarda 1968: 4.13^2 for 0.1 % and 80 %; Patnaik 1949, table for 5 % and 90 %.
TEST(NoncentralChiSquare, HasThePublishedNoncentralities) {
  EXPECT_NEAR(noticed_noncentrality(1e-3, 0.8, 1), 4.1321 * 4.1321, 2e-3);
  EXPECT_NEAR(noticed_noncentrality(0.05, 0.9, 1), 10.507, 1e-2);
  EXPECT_NEAR(noticed_noncentrality(0.05, 0.9, 5), 16.469, 1e-2);
}

// 20,000 draws: 4 sigma of a share of a half is 0.014.
TEST(NoncentralChiSquare, IsTheShareOfDraws) {
  Random random(4);
  constexpr int kDraws = 20'000;
  int n_beyond = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double first = random.normal() + 3;
    const double second = random.normal() - 2;
    const double third = random.normal();
    if (first * first + second * second + third * third > 15) ++n_beyond;
  }
  EXPECT_NEAR(noncentral_chi_square_exceedance(15, 3, 13), n_beyond / double{kDraws}, 0.014);
}

TEST(ChiSquare, HasEnds) {
  EXPECT_EQ(chi_square_exceedance(0, 3), 1);
  EXPECT_EQ(chi_square_exceedance(std::numeric_limits<double>::infinity(), 4), 0);
  EXPECT_TRUE(std::isnan(chi_square_exceedance(std::nan(""), 4)));
}

}  // namespace
}  // namespace panelcal
