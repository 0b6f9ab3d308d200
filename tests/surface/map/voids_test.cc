// SPDX-License-Identifier: Apache-2.0
#include "surface/map/voids.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

Position<frame::Nominal> at(double x_mm, double y_mm) {
  return position_mm<frame::Nominal>(x_mm, y_mm);
}

/// An L, clockwise, whose notch is the upper right quarter.
const Polygon kL = {{at(0, 0), at(0, 20), at(10, 20), at(10, 10), at(20, 10), at(20, 0)}};

TEST(Area, HoldsItsPlacesAndItsBorder) {
  const Area circle = Circle{at(5, 5), mm(2)};
  EXPECT_TRUE(is_within(circle, at(7, 5)));
  EXPECT_FALSE(is_within(circle, at(6.5, 6.5)));
  EXPECT_TRUE(is_within(circle, at(6.5, 6.5), mm(0.2)));

  EXPECT_TRUE(is_within(kL, at(5, 15)));
  EXPECT_FALSE(is_within(kL, at(15, 15)));
  EXPECT_TRUE(is_within(kL, at(10, 15)));
  EXPECT_TRUE(is_within(kL, at(0, 0)));
  EXPECT_FALSE(is_within(kL, at(-0.5, 10)));
  EXPECT_TRUE(is_within(kL, at(10.5, 15), mm(0.5)));

  const Area track = Track{{at(0, 0), at(10, 0), at(10, 10)}, mm(2)};
  EXPECT_TRUE(is_within(track, at(5, 1)));
  EXPECT_TRUE(is_within(track, at(11, 5)));
  EXPECT_TRUE(is_within(track, at(-0.6, -0.6)));
  EXPECT_FALSE(is_within(track, at(-0.8, -0.8)));
  EXPECT_FALSE(is_within(track, at(5, 5)));

  const Area outside = Outside{kL};
  EXPECT_TRUE(is_within(outside, at(15, 15)));
  EXPECT_TRUE(is_within(outside, at(1000, -1000)));
  EXPECT_FALSE(is_within(outside, at(5, 5)));
  EXPECT_TRUE(is_within(outside, at(0.5, 5), mm(0.5)));
}

TEST(Area, RefusesWhatIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const Area& area, const char* text) {
    EXPECT_THAT(check_area(area, "clamp", {"m.toml", 7, 1}), FailsWith(Code::ConfigValue, text));
  };
  refused(Circle{at(0, 0), mm(0)}, "m.toml:7:1: error[config-value]");
  refused(Circle{at(0, 0), mm(nan)}, "nan mm");
  refused(Circle{at(nan, 0), mm(1)}, "center");
  refused(Polygon{{at(0, 0), at(1, 0)}}, "2 corners");
  refused(Polygon{{at(0, 0), at(1, 0), at(2, 0)}}, "area");
  refused(Polygon{{at(0, 0), at(2, 2), at(2, 0), at(0, 2.5)}}, "cross");
  refused(Outside{{{at(0, 0), at(1e300, 0), at(0, 1)}}}, "corner");
  refused(Track{{}, mm(1)}, "0 points");
  refused(Track{{at(0, 0)}, mm(-1)}, "-1 mm");
  EXPECT_TRUE(check_area(kL, "L", {}));
  EXPECT_TRUE(check_area(rectangle(at(-1, -1), at(2, 3)), "zone", {}));
}

TEST(Voids, GiveTheFirstThatHoldsAPlace) {
  const auto voids = Voids::make({{Circle{at(5, 5), mm(2)}, "hole", {}},
                                  {kL, "clamp", {}},
                                  {Outside{rectangle(at(-50, -50), at(50, 50))}, "edge", {}}},
                                 mm(0.5));
  ASSERT_TRUE(voids) << voids.error().text();
  EXPECT_EQ(voids->at(at(5, 6.9))->name, "hole");
  EXPECT_EQ(voids->at(at(5, 7.4))->name, "clamp");
  EXPECT_EQ(voids->at(at(49.7, 0)), nullptr);
  // The tip of a probe has a radius.
  EXPECT_EQ(voids->touched_at(at(5, 7.4))->name, "hole");
  EXPECT_EQ(voids->touched_at(at(5, 7.6))->name, "clamp");
  EXPECT_EQ(voids->touched_at(at(49.7, 0))->name, "edge");
  EXPECT_EQ(voids->at(at(1e9, 1e9))->name, "edge");
  EXPECT_EQ(voids->at(at(15, 15)), nullptr);
  EXPECT_EQ(Voids().at(at(0, 0)), nullptr);
  EXPECT_EQ(Voids::make({})->at(at(0, 0)), nullptr);
  EXPECT_THAT(Voids::make({}, mm(-1)), FailsWith(Code::ConfigValue, "margin_mm"));
  EXPECT_THAT(Voids::make({{Circle{at(0, 0), mm(0)}, "hole", {}}}),
              FailsWith(Code::ConfigValue, "\"hole\""));
}

TEST(Voids, HaveNotTooManyCorners) {
  Polygon round;
  for (int i = 0; i < 2000; ++i) {
    const double angle_rad = 2e-3 * 3.14159265358979 * i / 2;
    round.corners.push_back(at(std::cos(angle_rad), std::sin(angle_rad)));
  }
  EXPECT_TRUE(Voids::make(std::vector<Void>(5, {round, "round", {}})));
  EXPECT_THAT(Voids::make(std::vector<Void>(6, {round, "round", {"zones.toml", 3, 1}})),
              FailsWith(Code::ConfigValue, "zones.toml:3:1"));
  round.corners.push_back(at(0.9999, -1e-4));
  EXPECT_THAT(check_area(round, "round", {}), FailsWith(Code::ConfigValue, "2001 corners"));
}

TEST(Voids, FindAsIfAllWereLookedAt) {
  Random random(140);
  std::vector<Void> all;
  for (int i = 0; i < 300; ++i) {
    const auto center = at(random.uniform(0, 400), random.uniform(-100, 200));
    // Some as large as half of the panel.
    const double radius_mm = i % 50 == 0 ? random.uniform(20, 100) : random.uniform(0.1, 6);
    if (i % 3 == 0) {
      const auto end = at(center.in_mm().x() + random.uniform(-30, 30),
                          center.in_mm().y() + (i % 2 == 0 ? random.uniform(-80, 80) : 0));
      all.push_back({Track{{center, end}, mm(radius_mm)}, std::to_string(i), {}});
    } else {
      all.push_back({Circle{center, mm(radius_mm)}, std::to_string(i), {}});
    }
  }
  const auto voids = Voids::make(all, mm(0.3));
  ASSERT_TRUE(voids) << voids.error().text();
  int n_inside = 0;
  for (int k = 0; k < 5000; ++k) {
    const auto place = at(random.uniform(-20, 420), random.uniform(-120, 220));
    const auto right = std::ranges::find_if(
        all, [&](const Void& one) { return is_within(one.area, place, mm(0.3)); });
    const Void* const found = voids->touched_at(place);
    ASSERT_EQ(found == nullptr, right == all.end());
    EXPECT_EQ(voids->at(place) != nullptr, std::ranges::any_of(all, [&](const Void& one) {
                return is_within(one.area, place);
              }));
    if (found == nullptr) continue;
    EXPECT_EQ(found->name, right->name);
    ++n_inside;
  }
  EXPECT_GT(n_inside, 500);
  EXPECT_LT(n_inside, 4500);
}

}  // namespace
}  // namespace panelcal
