// SPDX-License-Identifier: Apache-2.0
#include "calib/base/units.h"

#include <numbers>
#include <type_traits>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

static_assert(mm(1).in_mm() == 1);
static_assert(inch(1).in_mm() == 25.4);
static_assert(inch(2).in_inch() == 2);
static_assert(mm(0.5).in_um() == 500);
static_assert(px(4.5).in_px() == 4.5);
static_assert(rpm(80000).in_rpm() == 80000);
static_assert(seconds(0.25).in_s() == 0.25);
static_assert(mm_per_s(3).in_mm_s() == 3);
static_assert(mm(1) + mm(2) == mm(3) && mm(3) - mm(2) == mm(1) && -mm(1) == mm(-1));
static_assert(2 * mm(3) == mm(6) && mm(3) * 2 == mm(6) && mm(6) / 2 == mm(3));
static_assert(mm(6) / mm(3) == 2);
static_assert(mm(1) < inch(1) && um(1) < mm(1) && rad(0) == Angle());

// A bare number is no quantity, and no quantity is another.
static_assert(!std::is_convertible_v<double, Length>);
static_assert(!std::is_constructible_v<Length, double>);
static_assert(!std::is_convertible_v<Length, double>);
static_assert(!std::is_convertible_v<Length, Angle>);
static_assert(!std::is_convertible_v<Length, PixelLength>);
static_assert(!std::is_convertible_v<Feed, SpindleSpeed>);

TEST(Units, ConvertWhereTheyShould) {
  EXPECT_DOUBLE_EQ(um(20).in_mm(), 0.02);
  EXPECT_DOUBLE_EQ(deg(180).in_rad(), std::numbers::pi);
  EXPECT_DOUBLE_EQ(rad(std::numbers::pi / 2).in_deg(), 90);
  EXPECT_DOUBLE_EQ(inch(0.125).in_mm(), 3.175);
  EXPECT_DOUBLE_EQ(mm(3.175).in_inch(), 0.125);
  EXPECT_DOUBLE_EQ(inch_per_min(60).in_mm_s(), 25.4);
}

}  // namespace
}  // namespace panelcal
