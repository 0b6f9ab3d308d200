// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/chi_square.h"

#include <cmath>
#include <limits>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

TEST(ChiSquare, KnowsTheTables) {
  // Abramowitz and Stegun, table 26.8, to its six figures.
  EXPECT_NEAR(chi_square_exceedance(3.84146, 1), 0.05, 1e-6);
  EXPECT_NEAR(chi_square_exceedance(5.99146, 2), 0.05, 1e-6);
  EXPECT_NEAR(chi_square_exceedance(11.0705, 5), 0.05, 1e-5);
  EXPECT_NEAR(chi_square_exceedance(124.342, 100), 0.05, 1e-5);
  EXPECT_EQ(chi_square_exceedance(0, 3), 1);
  EXPECT_EQ(chi_square_exceedance(1e6, 3), 0);
}

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

/// One degree: |N(m, 1)| is below 2 in 1 of 100 if m is 2 + 2.3263, but for the far side.
TEST(ChiSquare, TellsHowMuchMayBeHidden) {
  EXPECT_NEAR(std::sqrt(largest_noncentrality(4, 1, 0.01)), 4.3263, 0.04 * 4.3263);
  // Baarda: 0.1 % false alarms and 80 % power are 4.13 sigmas.
  EXPECT_NEAR(std::sqrt(largest_noncentrality(10.8276, 1, 0.2)), 4.13, 0.04 * 4.13);
  EXPECT_EQ(largest_noncentrality(0.01, 9, 0.01), 0);
}

/// The limit holds what is drawn: three degrees, one of them displaced.
TEST(ChiSquare, HidesMoreThanTheLimitOnlyAsOftenAsStated) {
  Random random(20261126);
  constexpr int kDraws = 20'000;
  for (const double displaced : {3.0, 5.0, 9.0}) {
    int n_beyond = 0;
    for (int i = 0; i < kDraws; ++i) {
      const double x = displaced + random.normal();
      const double y = random.normal();
      const double z = random.normal();
      n_beyond +=
          largest_noncentrality(x * x + y * y + z * z, 3, 0.01) < displaced * displaced ? 1 : 0;
    }
    // To a third of 1 %, which the approximation is worth, and four of its deviations.
    EXPECT_NEAR(n_beyond / static_cast<double>(kDraws), 0.01, 0.0062) << displaced;
  }
}

TEST(ChiSquare, HasEnds) {
  EXPECT_EQ(chi_square_exceedance(0, 3), 1);
  EXPECT_EQ(chi_square_exceedance(std::numeric_limits<double>::infinity(), 4), 0);
  EXPECT_TRUE(std::isnan(chi_square_exceedance(std::nan(""), 4)));
}

}  // namespace
}  // namespace panelcal
