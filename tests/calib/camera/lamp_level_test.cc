// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/lamp_level.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>

namespace panelcal {
namespace {

/// A mark of reflectance 0.9 on a ground of 0.3, full scale at the level 100 / 0.9; levels tried.
std::vector<LampSample> pictures(const std::vector<double>& levels, double gain = 0.01) {
  std::vector<LampSample> out;
  for (const double level : levels) {
    const double mark = 0.9 * gain * level;
    const double ground = 0.3 * gain * level;
    out.push_back({level, std::min(mark, 1.0) - std::min(ground, 1.0), mark >= 1 ? 0.2 : 0.0});
  }
  return out;
}

TEST(LampLevel, IsTheBrightestThatDoesNotClip) {
  const auto best = best_lamp_level(pictures({160, 20, 60, 100, 140, 120}), {}, nullptr);
  ASSERT_TRUE(best);
  EXPECT_EQ(best->level, 100);
  EXPECT_NEAR(best->contrast, 0.6, 1e-12);
  EXPECT_FALSE(best->is_at_end);
}

TEST(LampLevel, OfEqualOnesIsTheDarkest) {
  const std::vector<LampSample> samples = {
      {10, 0.30, 0}, {20, 0.495, 0}, {30, 0.50, 0}, {40, 0.499, 0}, {50, 0.4, 0}};
  const auto best = best_lamp_level(samples, {}, nullptr);
  ASSERT_TRUE(best);
  EXPECT_EQ(best->level, 20);
}

TEST(LampLevel, SaysThatItStoppedAtTheEnd) {
  const auto best = best_lamp_level(pictures({20, 40, 60}), {}, nullptr);
  ASSERT_TRUE(best);
  EXPECT_EQ(best->level, 60);
  EXPECT_TRUE(best->is_at_end);
}

TEST(LampLevel, TrustsNothingAboveOneThatClips) {
  const std::vector<LampSample> samples = {
      {10, 0.2, 0}, {20, 0.3, 0.01}, {30, 0.9, 0}, {40, 0.95, 0}};
  const auto best = best_lamp_level(samples, {}, nullptr);
  ASSERT_TRUE(best);
  EXPECT_EQ(best->level, 10);
}

TEST(LampLevel, TakesTheWorstOfOneLevel) {
  const std::vector<LampSample> samples = {
      {10, 0.2, 0}, {20, 0.4, 0}, {20, 0.4, 0.5}, {30, 0.6, 0}};
  EXPECT_EQ(best_lamp_level(samples, {}, nullptr)->level, 10);
}

TEST(LampLevel, RefusesWithReasons) {
  std::string reason;
  EXPECT_FALSE(best_lamp_level(pictures({20, 40}), {}, &reason));
  EXPECT_EQ(reason, "2 lamp levels are too few for a choice");
  EXPECT_FALSE(best_lamp_level(pictures({200, 300, 400}), {}, &reason));
  EXPECT_THAT(reason, testing::HasSubstr("clips at every lamp level"));
  EXPECT_FALSE(best_lamp_level(pictures({1, 2, 3}), {}, &reason));
  EXPECT_THAT(reason, testing::HasSubstr("the contrast is 0.018 at best"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<LampSample> broken = {{1, nan, 0}, {nan, 1, 0}, {3, 1, nan}, {4, 0.5, 0}};
  EXPECT_FALSE(best_lamp_level(broken, {}, &reason));
  EXPECT_EQ(reason, "1 lamp levels are too few for a choice");
}

}  // namespace
}  // namespace panelcal
