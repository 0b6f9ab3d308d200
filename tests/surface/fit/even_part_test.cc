// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/even_part.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "tests/surface/fit/simulated_warp.h"

namespace panelcal::internal {
namespace {

using test::kWarpSide_mm;
using Points = std::vector<ProbePoint>;

Points gridded(int n_columns, int n_rows) {
  Random random(140);
  return test::probed_lattice(
      random, [](const Eigen::Vector2d&) { return 0.0; }, n_columns, n_rows);
}

double nearest_mm(const Points& points, const Eigen::Vector2d& p_mm, double above_mm) {
  double out_mm = std::numeric_limits<double>::infinity();
  for (const ProbePoint& point : points) {
    const double distance_mm = (point.place.in_mm() - p_mm).norm();
    if (distance_mm > above_mm) out_mm = std::min(out_mm, distance_mm);
  }
  return out_mm;
}

TEST(EvenPart, IsAllOverThePanelAndHasNeighbors) {
  const Points points = gridded(50, 40);
  const Points part = even_part(points, 200);
  ASSERT_EQ(part.size(), 200U);
  // 100 squares of 30 mm: nothing is farther from the middle of one than a diagonal.
  for (const ProbePoint& point : points) {
    EXPECT_LT(nearest_mm(part, point.place.in_mm(), -1), 0.1 * kWarpSide_mm * std::sqrt(2.0));
  }
  // The grid's own neighbours stand 300 / 49 mm and 300 / 39 mm apart.
  for (const ProbePoint& point : part) {
    EXPECT_LT(nearest_mm(part, point.place.in_mm(), 1e-6), kWarpSide_mm / 39 + 1e-6);
  }
}

TEST(EvenPart, KeepsTheOrderAndTakesNoneTwice) {
  const Points points = gridded(30, 30);
  std::vector<int> lines;
  for (const ProbePoint& point : even_part(points, 77)) lines.push_back(point.from.line);
  EXPECT_TRUE(std::ranges::is_sorted(lines));
  EXPECT_EQ(std::set<int>(lines.begin(), lines.end()).size(), lines.size());
  EXPECT_EQ(lines.size(), 76U);
  // Of places that coincide, too.
  EXPECT_FALSE(even_part(Points(9, points[0]), 4).empty());
}

TEST(Neighborhoods, HaveEveryProbeOnceAndAreCompact) {
  const Points points = gridded(40, 30);
  const auto found = neighborhoods(points, 100);
  std::vector<std::size_t> all;
  for (const auto& near : found) {
    EXPECT_LE(near.size(), 100U);
    EXPECT_GT(near.size(), 50U);
    EXPECT_TRUE(std::ranges::is_sorted(near));
    all.insert(all.end(), near.begin(), near.end());
    for (const std::size_t i : near) {
      const auto apart_mm = (points[i].place - points[near.front()].place).in_mm();
      EXPECT_LT(apart_mm.norm(), 0.5 * kWarpSide_mm);
    }
  }
  std::ranges::sort(all);
  std::vector<std::size_t> expected(points.size());
  std::iota(expected.begin(), expected.end(), std::size_t{0});
  EXPECT_EQ(all, expected);
  EXPECT_EQ(neighborhoods(points, points.size()).size(), 1U);
}

}  // namespace
}  // namespace panelcal::internal
