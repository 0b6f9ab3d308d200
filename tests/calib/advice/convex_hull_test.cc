// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/convex_hull.h"

#include <cmath>
#include <numbers>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

namespace panelcal {
namespace {

using NominalPlace = Position<frame::Nominal>;

NominalPlace place(double x_mm, double y_mm) {
  return position_mm<frame::Nominal>(x_mm, y_mm);
}

TEST(ConvexHull, KeepsCornersOnly) {
  const std::vector<NominalPlace> places = {
      place(0, 0), place(2, 0), place(1, 0), place(2, 2), place(1, 1), place(0, 2), place(0, 2)};
  const auto hull = convex_hull(places);
  ASSERT_EQ(hull.size(), 4u);
  double area = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d a = hull[i].in_mm();
    const Eigen::Vector2d b = hull[(i + 1) % 4].in_mm();
    area += (a.x() * b.y() - a.y() * b.x()) / 2;
  }
  EXPECT_DOUBLE_EQ(area, 4);  // positive: counter-clockwise
}

TEST(ConvexHull, OfALineHasItsEnds) {
  const auto hull = convex_hull(std::vector{place(1, 1), place(3, 3), place(2, 2), place(1, 1)});
  ASSERT_EQ(hull.size(), 2u);
  EXPECT_EQ(hull[0].in_mm(), Eigen::Vector2d(1, 1));
  EXPECT_EQ(hull[1].in_mm(), Eigen::Vector2d(3, 3));
  EXPECT_EQ(convex_hull(std::vector{place(1, 1), place(1, 1)}).size(), 1u);
  EXPECT_TRUE(convex_hull({}).empty());
}

TEST(ConvexHull, MeasuresHowFarOutsideAPlaceIs) {
  const std::vector<NominalPlace> square = {place(0, 0), place(2, 0), place(2, 2), place(0, 2)};
  EXPECT_EQ(distance_outside(square, place(1, 1)), mm(0));
  EXPECT_EQ(distance_outside(square, place(2, 1)), mm(0));
  EXPECT_EQ(distance_outside(square, place(5, 1)), mm(3));
  EXPECT_DOUBLE_EQ(distance_outside(square, place(5, 6)).in_mm(), 5);
  const std::vector<NominalPlace> line = {place(0, 0), place(2, 0)};
  EXPECT_EQ(distance_outside(line, place(1, 0)), mm(0));
  EXPECT_EQ(distance_outside(line, place(1, 3)), mm(3));
  EXPECT_EQ(distance_outside(std::vector{place(1, 1)}, place(1, 3)), mm(2));
}

TEST(HullBuilder, AgreesWithTheHullOfAll) {
  Random random(8);
  std::vector<NominalPlace> all;
  HullBuilder builder;
  for (int i = 0; i < 50'000; ++i) {
    all.push_back(place(random.normal(), random.normal()));
    builder.add(all.back());
  }
  const auto expected = convex_hull(all);
  const auto hull = builder.corners();
  ASSERT_EQ(hull.size(), expected.size());
  for (std::size_t i = 0; i < hull.size(); ++i) EXPECT_EQ(hull[i].in_mm(), expected[i].in_mm());
}

TEST(HullBuilder, LosesNoMoreOfACircleThanItSays) {
  HullBuilder builder;
  std::vector<NominalPlace> all;
  for (int i = 0; i < 40'000; ++i) {
    const double angle = 2 * std::numbers::pi * i / 40'000;
    all.push_back(place(100 * std::cos(angle), 100 * std::sin(angle)));
    builder.add(all.back());
  }
  const auto hull = builder.corners();
  EXPECT_LE(hull.size(), HullBuilder::kMost);
  const double bound_mm = 200 * std::tan(std::numbers::pi / HullBuilder::kMost) / 2;
  for (const NominalPlace& p : all) EXPECT_LE(distance_outside(hull, p).in_mm(), bound_mm);
}

}  // namespace
}  // namespace panelcal
