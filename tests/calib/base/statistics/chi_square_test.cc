// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/chi_square.h"

#include <cmath>
#include <limits>

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

TEST(ChiSquare, HasEnds) {
  EXPECT_EQ(chi_square_exceedance(0, 3), 1);
  EXPECT_EQ(chi_square_exceedance(std::numeric_limits<double>::infinity(), 4), 0);
  EXPECT_TRUE(std::isnan(chi_square_exceedance(std::nan(""), 4)));
}

}  // namespace
}  // namespace panelcal
