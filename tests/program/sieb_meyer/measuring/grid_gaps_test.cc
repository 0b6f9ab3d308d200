// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/measuring/grid_gaps.h"

#include <cmath>

#include "surface/map/height_map.h"
#include <gmock/gmock.h>

namespace panelcal::sieb_meyer {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

double height_mm(const Eigen::Vector2d& p_mm) {
  return 1.6 + 1e-3 * p_mm.x() + 2e-5 * p_mm.y() * p_mm.y();
}

/// Five columns and four rows, 10 mm apart; the second Z axis reads 0.1 mm more.
std::vector<GridPoint> lattice(const std::vector<Eigen::Vector2d>& without_mm) {
  std::vector<GridPoint> points;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d p_mm = 10.0 * Eigen::Vector2d(i % 5, i / 5);
    if (std::ranges::find(without_mm, p_mm) != without_mm.end()) continue;
    const double scatter_mm = i % 3 == 0 ? 0.001 : -0.0005;
    const double h_mm = height_mm(p_mm) + scatter_mm;
    points.push_back({p_mm, {{mm(h_mm), um(1)}, {mm(h_mm + 0.1), um(1)}}});
  }
  return points;
}

TEST(GridGaps, AreTheNodesWithoutAPoint) {
  EXPECT_THAT(missing_nodes(lattice({})), IsEmpty());
  EXPECT_THAT(missing_nodes(lattice({{40, 30}, {20, 10}})),
              ElementsAre(Eigen::Vector2d(20, 10), Eigen::Vector2d(40, 30)));
}

TEST(GridGaps, AreFilledFromTheOthersOfTheirAxis) {
  const std::vector<GridPoint> points = lattice({{20, 10}, {40, 30}});
  const auto filled = fill_nodes(points, missing_nodes(points), mm(10));
  ASSERT_TRUE(filled) << filled.error().text();
  ASSERT_EQ(filled->size(), 2U);
  for (const FilledNode& node : *filled) {
    ASSERT_EQ(node.heights.size(), 2U);
    const double off_um = (node.heights[0].height - mm(height_mm(node.place.in_mm()))).in_um();
    EXPECT_LT(std::abs(off_um), 4 * node.heights[0].sigma.in_um());
    EXPECT_LT(node.heights[0].sigma, um(10));
    EXPECT_NEAR((node.heights[1].height - node.heights[0].height).in_mm(), 0.1, 1e-6);
  }
  EXPECT_EQ((*filled)[0].source, HeightSource::Filled);
  EXPECT_EQ((*filled)[1].source, HeightSource::Extrapolated);
  // A corner is less certain than a place between probes.
  EXPECT_GT((*filled)[1].heights[0].sigma, (*filled)[0].heights[0].sigma);
}

TEST(GridGaps, AreNotFilledFarOutside) {
  const std::vector<GridPoint> points = lattice({{40, 30}});
  const auto filled = fill_nodes(points, missing_nodes(points), mm(3));
  ASSERT_FALSE(filled);
  EXPECT_EQ(filled.error().code, Code::GridInvalid);
  EXPECT_THAT(filled.error().text(), testing::HasSubstr("3.000 mm"));
}

TEST(GridGaps, AreNotFilledFromAFew) {
  std::vector<GridPoint> points = lattice({{20, 10}});
  points.resize(11);
  const auto filled = fill_nodes(points, missing_nodes(points), mm(10));
  ASSERT_FALSE(filled);
  EXPECT_THAT(filled.error().text(), testing::HasSubstr("12"));
}

TEST(GridGaps, OfAPerfectBoardAreLevel) {
  std::vector<GridPoint> points = lattice({{20, 10}});
  for (GridPoint& point : points) point.heights = {{mm(1.6), Length()}};
  const auto filled = fill_nodes(points, missing_nodes(points), mm(10));
  ASSERT_TRUE(filled) << filled.error().text();
  EXPECT_NEAR(filled->front().heights.front().height.in_mm(), 1.6, 1e-6);
}

}  // namespace
}  // namespace panelcal::sieb_meyer
