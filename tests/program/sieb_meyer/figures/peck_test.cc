// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/figures/peck.h"

#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::sieb_meyer {
namespace {

using testing::AllOf;
using testing::DoubleNear;
using testing::HasSubstr;
using testing::Pointwise;

constexpr double kExact_mm = 1e-9;  // subtracting depths of some mm

PeckStrokes peck(double distance, double first, double factor) {
  const auto strokes = peck_strokes(distance, first, factor);
  if (!strokes) ADD_FAILURE() << strokes.error();
  return strokes.value_or(PeckStrokes{});
}

std::string error_of(const tl::expected<PeckStrokes, std::string>& strokes) {
  return strokes ? "no error" : strokes.error();
}

auto are(const std::vector<double>& expected) {
  return Pointwise(DoubleNear(kExact_mm), expected);
}

TEST(PeckStrokes, ManualTableOfG81) {
  // I4.5 J1.2 W500 Z2.
  const PeckStrokes table = peck(4.5 - 2, 1.2, 500);
  EXPECT_THAT(table.strokes_mm,
              are({1.2, 0.6, 0.3, 0.15, 0.075, 0.037, 0.018, 0.009, 0.004, 0.002, 0.001}));
  EXPECT_FALSE(table.reaches_target);
  EXPECT_NEAR(table.remaining_mm, 0.104, kExact_mm);
  std::vector<double> depths = {4.5};
  for (const double stroke : table.strokes_mm) depths.push_back(depths.back() - stroke);
  EXPECT_THAT(depths,
              are({4.5, 3.3, 2.7, 2.4, 2.25, 2.175, 2.138, 2.12, 2.111, 2.107, 2.105, 2.104}));
}

TEST(PeckStrokes, ManualTableOfW) {
  // The same program. The strokes are printed alike; the depths up to the fifth row too, then
  // "2.325 - 0.037 = 2.138", "2.288 - 0.018 = 2.119" carry a slip of 1 um to the end.
  const PeckStrokes table = peck(4.5 - 2, 1.2, 500);
  const std::vector<double> printed = {
      3.3, 2.7, 2.4, 2.25, 2.175, 2.138, 2.119, 2.11, 2.106, 2.104, 2.103};
  ASSERT_EQ(table.strokes_mm.size(), printed.size());
  double depth = 4.5;
  for (std::size_t i = 0; i < printed.size(); ++i) {
    depth -= table.strokes_mm[i];
    EXPECT_NEAR(depth, printed[i] + (i < 6 ? 0 : 0.001), kExact_mm) << i;
  }
}

TEST(PeckStrokes, ManualExampleOfEvenStrokes) {
  // I5. J1.4 W1000 with Z1.0: 1.4, 2.8 and 4.0 mm.
  const PeckStrokes strokes = peck(5.0 - 1.0, 1.4, 1000);
  EXPECT_THAT(strokes.strokes_mm, are({1.4, 1.4, 1.2}));
  EXPECT_TRUE(strokes.reaches_target);
  EXPECT_EQ(strokes.remaining_mm, 0);
}

TEST(PeckStrokes, RoundedDifferencesMakeNoStrokeOfNothing) {
  for (int n = 1; n <= 500; ++n) {
    const double low = 0.1 * n;
    const PeckStrokes strokes = peck((low + 1.4 * n) - low, 1.4, 1000);
    EXPECT_EQ(strokes.strokes_mm.size(), static_cast<std::size_t>(n));
    EXPECT_TRUE(strokes.reaches_target);
  }
}

TEST(PeckStrokes, TheTargetLimitsTheLastStroke) {
  // 0.8 + 0.72 + 0.648 = 2.168; the fourth of 0.5832, cut to 0.583, is limited to 0.332.
  const PeckStrokes strokes = peck(2.5, 0.8, 900);
  EXPECT_THAT(strokes.strokes_mm, are({0.8, 0.72, 0.648, 0.332}));
  EXPECT_TRUE(strokes.reaches_target);
  EXPECT_THAT(peck(0.3, 0.8, 900).strokes_mm, are({0.3}));
}

TEST(PeckStrokes, NothingToDo) {
  const PeckStrokes none = peck(0, 1, 500);
  EXPECT_TRUE(none.strokes_mm.empty());
  EXPECT_TRUE(none.reaches_target);
}

TEST(PeckStrokes, NoFactorIsOneStroke) {
  const PeckStrokes one = peck(2, 0.5, 0);
  EXPECT_THAT(one.strokes_mm, are({0.5}));
  EXPECT_FALSE(one.reaches_target);
  EXPECT_NEAR(one.remaining_mm, 1.5, kExact_mm);
  const PeckStrokes none = peck(2, 0.0009, 1000);
  EXPECT_TRUE(none.strokes_mm.empty());
  EXPECT_EQ(none.remaining_mm, 2);
}

TEST(PeckStrokes, TheNumberIsBounded) {
  EXPECT_EQ(peck(100, 0.001, 1000).strokes_mm.size(), 100000U);
  EXPECT_THAT(error_of(peck_strokes(100.001, 0.001, 1000)), HasSubstr("100000"));
  EXPECT_THAT(error_of(peck_strokes(1e300, 0.001, 1000)), HasSubstr("too many"));
}

TEST(PeckStrokes, RefusesBadNumbers) {
  EXPECT_THAT(error_of(peck_strokes(-0.5, 1, 500)), HasSubstr("0.5 mm"));
  EXPECT_THAT(error_of(peck_strokes(1, 0, 500)), HasSubstr("0 mm"));
  EXPECT_THAT(error_of(peck_strokes(1, -1, 500)), HasSubstr("above 0"));
  EXPECT_THAT(error_of(peck_strokes(1, 1, 1001)), AllOf(HasSubstr("1001"), HasSubstr("1000")));
  EXPECT_THAT(error_of(peck_strokes(1, 1, -1)), HasSubstr("W is -1"));
  EXPECT_THAT(error_of(peck_strokes(NAN, 1, 500)), HasSubstr("finite"));
  EXPECT_THAT(error_of(peck_strokes(1, 1, INFINITY)), HasSubstr("finite"));
}

}  // namespace
}  // namespace panelcal::sieb_meyer
