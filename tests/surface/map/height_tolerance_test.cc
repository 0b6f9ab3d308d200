// SPDX-License-Identifier: Apache-2.0
#include "surface/map/height_tolerance.h"

#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace panelcal {
namespace {

using testing::AllOf;
using testing::HasSubstr;

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
  EXPECT_THAT(refusal({2.6001}, {1.6}, {1}),
              AllOf(HasSubstr("zaxis 0"),
                    HasSubstr("2.6001 mm"),
                    HasSubstr("+1.0001 mm"),
                    HasSubstr("1.0000 mm")));
  EXPECT_THAT(refusal({0.5}, {1.6}, {1}),
              AllOf(HasSubstr("zaxis 0"),
                    HasSubstr("0.5000 mm"),
                    HasSubstr("-1.1000 mm"),
                    HasSubstr("1.0000 mm")));
}

TEST(HeightTolerance, EveryZAxisHasItsReference) {
  EXPECT_EQ(refusal({1, 2, 3}, {1.05, 2.05, 2.95}, {0.1}), "accepted");
  EXPECT_THAT(refusal({1, 2, 3}, {1, 2, 2.8}, {0.1}),
              AllOf(HasSubstr("zaxis 2"),
                    HasSubstr("3.0000 mm"),
                    HasSubstr("+0.2000 mm"),
                    HasSubstr("0.1000 mm")));
}

TEST(HeightTolerance, EveryZAxisMayHaveItsTolerance) {
  EXPECT_THAT(refusal({1, 2}, {1.5}, {0.6, 0.4}),
              AllOf(HasSubstr("zaxis 1"),
                    HasSubstr("2.0000 mm"),
                    HasSubstr("+0.5000 mm"),
                    HasSubstr("0.4000 mm")));
}

TEST(HeightTolerance, NamesTheWorstZAxis) {
  EXPECT_THAT(refusal({1.2, 1.5, 1.3}, {1}, {0.1}), HasSubstr("zaxis 1 "));
}

TEST(HeightTolerance, RefusesOtherNumbersOfZAxes) {
  EXPECT_THAT(refusal({1, 2, 3}, {1, 2}, {0.1}),
              AllOf(HasSubstr("3 heights"), HasSubstr("2 references"), HasSubstr("1 tolerance")));
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
