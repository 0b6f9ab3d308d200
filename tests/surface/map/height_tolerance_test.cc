// SPDX-License-Identifier: Apache-2.0
#include "surface/map/height_tolerance.h"

#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

std::string refusal(const std::vector<double>& heights_mm,
                    const std::vector<double>& reference_mm,
                    const std::vector<double>& tolerance_mm) {
  std::vector<HeightEstimate> heights;
  for (const double v_mm : heights_mm) heights.push_back({mm(v_mm), um(2)});
  std::vector<Length> reference, tolerance;
  for (const double v_mm : reference_mm) reference.push_back(mm(v_mm));
  for (const double v_mm : tolerance_mm) tolerance.push_back(mm(v_mm));
  const auto result = check_height("MAPT", heights, reference, tolerance);
  return result ? "accepted" : result.error();
}

// SIEB & MEYER CNC 8x.00, G78: MAPT1.0.
TEST(HeightTolerance, ManualMaptOfOneMillimetre) {
  EXPECT_EQ(refusal({1.6}, {1.6}, {1}), "accepted");
  EXPECT_EQ(refusal({2.6}, {1.6}, {1}), "accepted") << "just the tolerance";
  EXPECT_EQ(refusal({0.6}, {1.6}, {1}), "accepted");
  EXPECT_EQ(refusal({2.6001}, {1.6}, {1}),
            "the surface under zaxis 0 is at 2.6001 mm, +1.0001 mm off its reference, expected at "
            "most 1.0000 mm (MAPT)");
  EXPECT_EQ(refusal({0.5}, {1.6}, {1}),
            "the surface under zaxis 0 is at 0.5000 mm, -1.1000 mm off its reference, expected at "
            "most 1.0000 mm (MAPT)");
}

TEST(HeightTolerance, EveryZAxisHasItsReference) {
  EXPECT_EQ(refusal({1, 2, 3}, {1.05, 2.05, 2.95}, {0.1}), "accepted");
  EXPECT_EQ(refusal({1, 2, 3}, {1, 2, 2.8}, {0.1}),
            "the surface under zaxis 2 is at 3.0000 mm, +0.2000 mm off its reference, expected at "
            "most 0.1000 mm (MAPT)");
}

TEST(HeightTolerance, EveryZAxisMayHaveItsTolerance) {
  EXPECT_EQ(refusal({1, 2}, {1.5}, {0.6, 0.4}),
            "the surface under zaxis 1 is at 2.0000 mm, +0.5000 mm off its reference, expected at "
            "most 0.4000 mm (MAPT)");
}

TEST(HeightTolerance, NamesTheWorstZAxis) {
  EXPECT_TRUE(refusal({1.2, 1.5, 1.3}, {1}, {0.1}).starts_with("the surface under zaxis 1 "));
}

TEST(HeightTolerance, RefusesOtherNumbersOfZAxes) {
  EXPECT_EQ(refusal({1, 2, 3}, {1, 2}, {0.1}),
            "there are 3 heights, 2 references and 1 tolerances (MAPT), expected one for each Z "
            "axis");
  EXPECT_NE(refusal({1, 2, 3}, {1}, {0.1, 0.1}), "accepted");
  EXPECT_NE(refusal({}, {1}, {0.1}), "accepted");
  EXPECT_NE(refusal({1}, {}, {0.1}), "accepted");
}

TEST(HeightTolerance, RefusesNumbersThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal({nan}, {1}, {0.1}), "accepted");
  EXPECT_NE(refusal({1, 1}, {nan, 1}, {0.1}), "accepted");
  EXPECT_NE(refusal({1}, {1}, {nan}), "accepted");
}

}  // namespace
}  // namespace panelcal
