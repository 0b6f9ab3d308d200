// SPDX-License-Identifier: Apache-2.0
#include "tools/figures/contours.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>

namespace panelcal::contours {
namespace {

using Eigen::Vector2d;
using ::testing::DoubleNear;
using ::testing::IsEmpty;
using ::testing::Pointwise;

/// n x n cells over -1 .. 1.
template <class Value>
Field field_of(int n, const Value& value) {
  Field out;
  for (int i = 0; i <= n; ++i) {
    out.x.push_back(-1 + 2.0 * i / n);
    out.y.push_back(-1 + 2.0 * i / n);
  }
  for (const double y : out.y) {
    for (const double x : out.x) out.values.push_back(value(x, y));
  }
  return out;
}

/// Of what is within an odd number of closed lines, as these nest.
double area_of(const std::vector<Line>& lines) {
  double sum = 0;
  for (const Line& line : lines) {
    double twice = 0;
    for (std::size_t i = 0; i < line.points.size(); ++i) {
      const Vector2d& a = line.points[i];
      const Vector2d& b = line.points[(i + 1) % line.points.size()];
      twice += a.x() * b.y() - a.y() * b.x();
    }
    // Lines that lie within another one would count negative; no test has them.
    sum += std::abs(twice) / 2;
  }
  return sum;
}

TEST(Contours, FollowACircle) {
  const Field field = field_of(60, [](double x, double y) { return x * x + y * y; });
  const std::vector<Line> lines = level_lines(field, 0.49);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_TRUE(lines[0].is_closed);
  // On a side, linear interpolation of a parabola is off by h^2 / 8 of its curvature at most.
  for (const Vector2d& p : lines[0].points) EXPECT_NEAR(p.norm(), 0.7, 1e-3);
  EXPECT_NEAR(lines[0].length(), 2 * std::numbers::pi * 0.7, 0.1);
}

TEST(Contours, EndAtTheBorder) {
  const Field field = field_of(7, [](double x, double y) { return x + 0.1 * y; });
  const std::vector<Line> lines = level_lines(field, 0.05);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_FALSE(lines[0].is_closed);
  EXPECT_NEAR(lines[0].length(), std::hypot(2, 0.2), 1e-9);
  for (const Vector2d& p : lines[0].points) EXPECT_NEAR(p.x() + 0.1 * p.y(), 0.05, 1e-12);
}

TEST(Contours, AreasCloseAlongTheBorder) {
  const Field field = field_of(40, [](double x, double y) { return x + 0.1 * y; });
  EXPECT_NEAR(area_of(level_area(field, 0)), 2, 1e-9);
  EXPECT_NEAR(area_of(level_area(field, 0.5)), 1, 1e-9);
  EXPECT_NEAR(area_of(level_area(field, -2)), 4, 1e-9);
  EXPECT_THAT(level_area(field, 2), IsEmpty());
  for (const Line& line : level_area(field, 0)) EXPECT_TRUE(line.is_closed);
}

TEST(Contours, PartASaddleByItsMiddle) {
  // Up at two opposite corners; the mean of the four decides.
  const Field high{{0, 1}, {0, 1}, {1, 0, 0, 0.8}};
  EXPECT_EQ(level_lines(high, 0.4).size(), 2U);
  for (const Line& line : level_lines(high, 0.4)) {
    const Vector2d middle = 0.5 * (line.points.front() + line.points.back());
    // Below 0.45, the mean: the low corners are cut off.
    EXPECT_GT(std::abs(middle.x() - middle.y()), 0.3);
  }
  for (const Line& line : level_lines(high, 0.5)) {
    const Vector2d middle = 0.5 * (line.points.front() + line.points.back());
    EXPECT_GT(std::abs(middle.x() + middle.y() - 1), 0.2);
  }
}

TEST(Contours, FlatFieldsHaveNoLines) {
  const Field field = field_of(5, [](double, double) { return 3; });
  EXPECT_THAT(level_lines(field, 3), IsEmpty());
  EXPECT_NEAR(area_of(level_area(field, 3)), 4, 1e-12);
  EXPECT_THAT(round_levels(3, 3, 8), IsEmpty());
}

TEST(Contours, LevelsAreRound) {
  EXPECT_THAT(
      round_levels(0.03, 0.51, 4),
      Pointwise(DoubleNear(1e-12), {0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5}));
  EXPECT_THAT(round_levels(-1, 1, 3), Pointwise(DoubleNear(1e-12), {-0.5, 0.0, 0.5}));
  EXPECT_EQ(decimals_of({0.05, 0.1}), 2);
  EXPECT_EQ(decimals_of({100, 200}), 0);
}

}  // namespace
}  // namespace panelcal::contours
