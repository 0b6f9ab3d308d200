// SPDX-License-Identifier: Apache-2.0
#include "calib/spindle/f_exceedance.h"

#include <cmath>
#include <limits>

#include "calib/base/statistics/chi_square.h"
#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

#include "tests/support/statistics.h"

namespace panelcal {
namespace {

TEST(FExceedance, AgreesWithPrintedTables) {
  // Upper 5 % and 1 % points, to the digits that tables print (Abramowitz and Stegun, 26.9).
  EXPECT_NEAR(f_exceedance(5.14, 2, 6), 0.05, 2e-4);
  EXPECT_NEAR(f_exceedance(10.92, 2, 6), 0.01, 2e-5);
  EXPECT_NEAR(f_exceedance(3.63, 2, 16), 0.05, 3e-4);
  EXPECT_NEAR(f_exceedance(3.48, 4, 10), 0.05, 2e-4);
  EXPECT_NEAR(f_exceedance(5.99, 4, 10), 0.01, 1e-4);
}

TEST(FExceedance, IsThatOfARatioOfTwoSquares) {
  // 4 over 5 degrees of freedom, drawn as what an F variable is.
  constexpr int kDraws = 20000;
  constexpr double kLimit = 2.5;
  Random random(11);
  const auto mean_square = [&random](int n) {
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += std::pow(random.normal(), 2);
    return sum / n;
  };
  int n_above = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double above = mean_square(4);
    if (above / mean_square(5) > kLimit) ++n_above;
  }
  const double p = f_exceedance(kLimit, 4, 5);
  EXPECT_TRUE(
      test::mean_agrees(static_cast<double>(n_above) / kDraws, p, std::sqrt(p * (1 - p)), kDraws));
}

TEST(FExceedance, BecomesAChiSquare) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_DOUBLE_EQ(f_exceedance(1.7, 4, kInfinity), chi_square_exceedance(6.8, 4));
  EXPECT_NEAR(f_exceedance(1.7, 4, 1e9), chi_square_exceedance(6.8, 4), 1e-8);
}

TEST(FExceedance, HasLimits) {
  EXPECT_EQ(f_exceedance(0, 2, 5), 1);
  EXPECT_EQ(f_exceedance(-1, 2, 5), 1);
  EXPECT_EQ(f_exceedance(std::numeric_limits<double>::infinity(), 2, 5), 0);
  EXPECT_TRUE(std::isnan(f_exceedance(std::nan(""), 2, 5)));
  EXPECT_TRUE(std::isnan(f_exceedance(1, 2, std::nan(""))));
}

}  // namespace
}  // namespace panelcal
