// SPDX-License-Identifier: Apache-2.0
#include "calib/faults/known_pads.h"

#include <algorithm>
#include <limits>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

std::vector<KnownPad> random_pads(Random& random, int n, double width_mm, double height_mm) {
  std::vector<KnownPad> pads;
  for (int i = 0; i < n; ++i) {
    const double x_mm = random.uniform(-width_mm, width_mm);
    const double y_mm = random.uniform(-height_mm, height_mm);
    pads.push_back({{x_mm, y_mm}, i + 1, 1});
  }
  return pads;
}

std::vector<int> lines_within(const KnownPads& pads, const Eigen::Vector2d& place, double radius) {
  std::vector<int> lines;
  for (const std::size_t i : pads.within(place, radius)) lines.push_back(pads.all()[i].line);
  return lines;
}

/// 200 questions to each of three panels: wide, a line, and all in one place but for rounding.
TEST(KnownPads, AnswersAsALookAtEveryPadDoes) {
  Random random(7);
  for (const double height_mm : {80.0, 0.0, 1e-4}) {
    const KnownPads pads(random_pads(random, 300, 100, height_mm));
    ASSERT_GE(pads.all().size(), 295U);  // a few fall together by chance
    const std::vector<KnownPad> all(pads.all().begin(), pads.all().end());
    for (int k = 0; k < 200; ++k) {
      const Eigen::Vector2d place(random.uniform(-120, 120), random.uniform(-120, 120));
      const double radius = random.uniform(0, 60);
      std::vector<KnownPad> near;
      for (const KnownPad& pad : all) {
        if ((pad.place_mm - place).norm() <= radius) near.push_back(pad);
      }
      std::ranges::sort(near, {}, [&](const KnownPad& p) { return (p.place_mm - place).norm(); });
      std::vector<int> lines;
      for (const KnownPad& pad : near) lines.push_back(pad.line);
      EXPECT_EQ(lines_within(pads, place, radius), lines);
    }
  }
}

TEST(KnownPads, KeepsTheFirstOfRepeatedOnes) {
  const KnownPads pads({{{1, 1}, 5, 2}, {{3, 3}, 6, 2}, {{1, 1}, 7, 3}, {{1.0000001, 1}, 8, 3}});
  ASSERT_EQ(pads.all().size(), 2U);
  EXPECT_EQ(lines_within(pads, {1, 1}, 0.1), std::vector<int>{5});
}

TEST(KnownPads, KnowsNothingWhereThereIsNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(KnownPads().within({0, 0}, 1e9).empty());
  EXPECT_TRUE(KnownPads({{{nan, 0}, 1, 1}}).all().empty());
  EXPECT_TRUE(KnownPads({{{1, 2}, 1, 1}}).within({nan, 0}, 5).empty());
  EXPECT_EQ(lines_within(KnownPads({{{1, 2}, 9, 1}}), {1, 2}, 0), std::vector<int>{9});
}

}  // namespace
}  // namespace panelcal
