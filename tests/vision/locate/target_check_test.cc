// SPDX-License-Identifier: Apache-2.0
#include "vision/locate/target_check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <numbers>
#include <string>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

constexpr int kSide_px = 90;
constexpr double kNoise = 4;
constexpr std::uint64_t kSeed = 5;

/// Signed distance to a mark's outline, positive inside, px; from a place off the middle.
using Mark = std::function<double(double, double)>;

Target template_of(const Mark& mark, Angle tolerance, double size_px = kSide_px) {
  auto picture = std::make_shared<TemplatePicture>();
  picture->file = "mark.png";
  picture->image = Image(kSide_px, kSide_px, 255);
  Random random(kSeed);
  for (int y = 0; y < kSide_px; ++y) {
    for (int x = 0; x < kSide_px; ++x) {
      const double share = 0.5 * std::erfc(-mark(x - 47.3, y - 42.6) / std::numbers::sqrt2);
      picture->image.at(x, y) = static_cast<float>(60 + 140 * share + kNoise * random.normal());
    }
  }
  Target target;
  target.shape = Shape::Template;
  target.size_px = px(size_px);
  target.picture = picture;
  target.angle_tolerance = tolerance;
  return target;
}

/// A star with round tips that looks the same in n ways.
Mark star(int n) {
  return [n](double x, double y) {
    return 20 + 5 * std::cos(n * std::atan2(y, x)) - std::hypot(x, y);
  };
}

std::string problem(const Mark& mark, double tolerance_deg) {
  const auto found = target_problem(template_of(mark, deg(tolerance_deg)), nullptr);
  if (!found) return "none";
  EXPECT_TRUE(found->is_of_angle);
  return found->why;
}

TEST(TargetCheck, StarsLookTheSameInAsManyWaysAsTheyHaveTips) {
  for (const int n : {2, 3, 4, 5, 6, 8}) {
    const std::string degrees = std::to_string(static_cast<int>(std::lround(360.0 / n)));
    const std::string same =
        "the template mark.png looks the same when turned by " + degrees + " degrees";
    EXPECT_EQ(problem(star(n), 180), same);
    EXPECT_EQ(problem(star(n), 180.0 / n + 2), same) << n;
    EXPECT_EQ(problem(star(n), 180.0 / n - 2), "none") << n;
  }
}

TEST(TargetCheck, AMarkOfOneWayMayBeTurnedFar) {
  const Mark star_of_two_and_three = [](double x, double y) {
    const double angle = std::atan2(y, x);
    return 20 + 4 * std::cos(2 * angle) + 4 * std::cos(3 * angle) - std::hypot(x, y);
  };
  EXPECT_EQ(problem(star_of_two_and_three, 180), "none");
  const Mark keyed = [](double x, double y) {
    return std::min(20 - std::hypot(x, y), std::hypot(x - 20, y) - 5);
  };
  EXPECT_EQ(problem(keyed, 180), "none");
}

TEST(TargetCheck, ARoundMarkIsFineUntilItsAngleMatters) {
  const Mark disc = star(0);
  EXPECT_EQ(problem(disc, 5), "none");
  EXPECT_EQ(problem(disc, 20), "the template mark.png looks the same when turned by 30 degrees");
}

/// The bar goes out of the picture: its end is not known, but it is not like the part turned in.
TEST(TargetCheck, WhatLeavesThePictureIsNotTheSame) {
  const Mark bar = [](double x, double y) {
    return std::max(8 - std::abs(y), std::min(8 - std::abs(x), 14 - std::abs(y)));
  };
  EXPECT_EQ(problem(bar, 90), "none");
}

TEST(TargetCheck, TooSmallInPictures) {
  const auto found = target_problem(template_of(star(4), deg(5), 6), nullptr);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->is_of_angle);
  EXPECT_EQ(found->why,
            "the template mark.png will not do: it would be 6 px wide in pictures, at least 8 are "
            "needed");
}

TEST(TargetCheck, OtherShapesHaveNothingToCheck) {
  Target disc;
  disc.size_px = px(40);
  EXPECT_FALSE(target_problem(disc, nullptr));
}

}  // namespace
}  // namespace panelcal::internal
