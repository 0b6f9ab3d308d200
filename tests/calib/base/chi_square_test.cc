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

TEST(ChiSquare, IsInverted) {
  EXPECT_NEAR(chi_square_exceeded(1e-3, 3), 16.2662, 1e-4);
  EXPECT_NEAR(chi_square_exceeded(0.99, 3), 0.114832, 1e-6);
  EXPECT_NEAR(chi_square_exceeded(0.5, 5), 4.35146, 1e-5);
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
