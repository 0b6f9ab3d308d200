// SPDX-License-Identifier: Apache-2.0
#include "program/walk/execution/hole_sequence.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::IsNearMatrix;

constexpr double kExact_mm = 1e-10;  // roundings of doubles of some 100 mm

std::vector<Vector2d> all(const HoleSequence& holes) {
  std::vector<Vector2d> out;
  for (std::int64_t i = 0; i < holes.size(); ++i) out.push_back(holes[i]);
  return out;
}

TEST(HoleSequence, AnOutlineHasEachCornerOnce) {
  const std::vector<Vector2d> expected = {
      {0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 2}, {3, 4}, {2, 4}, {1, 4}, {0, 4}, {0, 2}};
  const std::vector<Vector2d> holes = all(HoleSequence::outline({0, 0}, {3, 0}, {3, 4}, 3, 2));
  ASSERT_EQ(holes.size(), expected.size());
  for (std::size_t i = 0; i < holes.size(); ++i) {
    EXPECT_THAT(holes[i], IsNearMatrix(expected[i], kExact_mm)) << i;
  }
}

TEST(HoleSequence, TheSmallestOutlineIsFourHoles) {
  EXPECT_EQ(all(HoleSequence::outline({1, 2}, {1, 5}, {7, 5}, 1, 1)),
            std::vector<Vector2d>({{1, 2}, {1, 5}, {7, 5}, {7, 2}}));
}

TEST(HoleSequence, ARingInPassesHalvesTheGaps) {
  // Eighths of a turn: start, opposite, quarters, then the eighths between.
  const std::vector<int> eighths = {0, 4, 2, 6, 1, 3, 5, 7};
  const HoleSequence ring = HoleSequence::ring({10, 20}, {0, 2}, 8);
  const HoleSequence passes = HoleSequence::ring_passes({10, 20}, {0, 2}, 8);
  ASSERT_EQ(passes.size(), 8);
  for (std::int64_t i = 0; i < 8; ++i) {
    EXPECT_EQ(passes[i], ring[eighths[static_cast<std::size_t>(i)]]) << i;
  }
  EXPECT_EQ(passes[2], Vector2d(8, 20));  // a quarter counterclockwise from (10, 22)
}

TEST(HoleSequence, ARingInPassesHasEachHoleOnce) {
  for (std::int64_t n = 1; n <= 4096; n *= 2) {
    const HoleSequence holes = HoleSequence::ring_passes({0, 0}, {5, 0}, n);
    std::vector<std::int64_t> seen;
    for (const Vector2d& hole : all(holes)) {
      const double turn = std::atan2(hole.y(), hole.x()) / (2 * std::acos(-1.0));
      seen.push_back((std::llround(turn * static_cast<double>(n)) + n) % n);
    }
    std::ranges::sort(seen);
    ASSERT_EQ(seen.size(), static_cast<std::size_t>(n));
    for (std::int64_t i = 0; i < n; ++i) ASSERT_EQ(seen[static_cast<std::size_t>(i)], i);
  }
}

TEST(HoleSequence, SizesDoNotNeedMemory) {
  constexpr std::int64_t kHalf = 250'000'000'000;
  const HoleSequence outline = HoleSequence::outline({0, 0}, {1, 0}, {1, 1}, kHalf, kHalf);
  EXPECT_EQ(outline.size(), 4 * kHalf);
  EXPECT_THAT(outline[outline.size() - 1], IsNearMatrix(Vector2d(0, 4e-12), 1e-15));
  const HoleSequence ring = HoleSequence::ring_passes({0, 0}, {1, 0}, std::int64_t{1} << 39);
  EXPECT_THAT(ring[ring.size() - 1], IsNearMatrix(Vector2d(1, 0), 1e-10));
}

TEST(SlotSteps, DoublesTheFirstOnes) {
  // Holes of 2 mm leave a cusp of 0.1 mm if they are 2 sqrt(0.1 (2 - 0.1)) = 0.8718 mm apart.
  EXPECT_EQ(slot_steps(0.871, 1, 2, 0.1), 1);
  EXPECT_EQ(slot_steps(0.873, 1, 2, 0.1), 2);
  EXPECT_EQ(slot_steps(0.871 * 12, 3, 2, 0.1), 12);
  EXPECT_EQ(slot_steps(0.873 * 12, 3, 2, 0.1), 24);
  EXPECT_EQ(slot_steps(1e13, 1, 0.1, 0.01), std::nullopt);
  EXPECT_EQ(slot_steps(INFINITY, 1, 0.1, 0.01), std::nullopt);
}

TEST(RingHoles, TheLeastNumber) {
  // 10 mm of 2.4 mm holes, path radius 3.8 mm: n holes leave cusps of
  // 5 - 3.8 cos(180/n) - sqrt(1.2^2 - (3.8 sin(180/n))^2): 0.01321 mm for 77, 0.01288 for 78.
  EXPECT_EQ(ring_holes(3.8, 2.4, 0.0133), 77);
  EXPECT_EQ(ring_holes(3.8, 2.4, 0.0131), 78);
  EXPECT_EQ(ring_holes(1e12, 0.1, 0.001), std::nullopt);
}

}  // namespace
}  // namespace panelcal
