// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/figures/corner_rounding.h"

#include <cmath>
#include <numbers>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::sieb_meyer {
namespace {

using Eigen::Vector2d;
using test::IsNearMatrix;
using testing::AllOf;
using testing::HasSubstr;
using Rounding = tl::expected<Arc, std::string>;

constexpr double kPi = std::numbers::pi;
constexpr double kExact_mm = 1e-9;

std::string error_of(const Rounding& rounding) {
  return rounding ? "no error" : rounding.error();
}

ContourPiece line(const Vector2d& start, const Vector2d& end) {
  return {.start_mm = start, .end_mm = end};
}

ContourPiece arc(const Vector2d& start,
                 const Vector2d& end,
                 const Vector2d& center,
                 bool clockwise) {
  return {.start_mm = start, .end_mm = end, .center_mm = center, .clockwise = clockwise};
}

ContourPiece reversed(const ContourPiece& piece) {
  return {.start_mm = piece.end_mm,
          .end_mm = piece.start_mm,
          .center_mm = piece.center_mm,
          .clockwise = !piece.clockwise};
}

Vector2d on_circle(const Vector2d& center, double radius, double angle) {
  return center + radius * Vector2d(std::cos(angle), std::sin(angle));
}

/// The direction of travel around a center.
Vector2d tangent(const Vector2d& point, const Vector2d& center, bool clockwise) {
  const Vector2d spoke = (point - center).normalized();
  return clockwise ? Vector2d(spoke.y(), -spoke.x()) : Vector2d(-spoke.y(), spoke.x());
}

Vector2d travel(const ContourPiece& piece, const Vector2d& point) {
  return piece.center_mm ? tangent(point, *piece.center_mm, piece.clockwise)
                         : Vector2d((piece.end_mm - piece.start_mm).normalized());
}

/// Position of a point along a piece, in parts of the piece; beyond 1 if it is not on it.
double part_of(const ContourPiece& piece, const Vector2d& point) {
  if (!piece.center_mm) {
    const Vector2d way = piece.end_mm - piece.start_mm;
    return (point - piece.start_mm).dot(way) / way.squaredNorm();
  }
  const auto angle_to = [&](const Vector2d& to) {
    const Vector2d a = piece.start_mm - *piece.center_mm;
    const Vector2d b = to - *piece.center_mm;
    const double turn = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    const double along = piece.clockwise ? -turn : turn;
    return along < -1e-9 ? along + 2 * kPi : along;
  };
  return angle_to(point) / angle_to(piece.end_mm);
}

void expect_on(const ContourPiece& piece, const Vector2d& point) {
  if (piece.center_mm) {
    EXPECT_NEAR(
        (point - *piece.center_mm).norm(), (piece.start_mm - *piece.center_mm).norm(), kExact_mm);
  } else {
    const Vector2d way = (piece.end_mm - piece.start_mm).normalized();
    const Vector2d off = point - piece.start_mm;
    EXPECT_NEAR(way.x() * off.y() - way.y() * off.x(), 0, kExact_mm);
  }
  EXPECT_GE(part_of(piece, point), -1e-9);
  EXPECT_LE(part_of(piece, point), 1 + 1e-9);
}

/// All that a rounding has to be.
void expect_rounds(const Arc& rounding,
                   const ContourPiece& first,
                   const ContourPiece& second,
                   double radius) {
  EXPECT_NEAR((rounding.start_mm - rounding.center_mm).norm(), radius, kExact_mm);
  EXPECT_NEAR((rounding.end_mm - rounding.center_mm).norm(), radius, kExact_mm);
  expect_on(first, rounding.start_mm);
  expect_on(second, rounding.end_mm);
  const Vector2d in = tangent(rounding.start_mm, rounding.center_mm, rounding.clockwise);
  const Vector2d out = tangent(rounding.end_mm, rounding.center_mm, rounding.clockwise);
  EXPECT_THAT(in, IsNearMatrix(travel(first, rounding.start_mm), kExact_mm / radius + 1e-9));
  EXPECT_THAT(out, IsNearMatrix(travel(second, rounding.end_mm), kExact_mm / radius + 1e-9));
  // At most half a circle, and turning as the corner does.
  const double turn = std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
  EXPECT_EQ(turn < 0, rounding.clockwise);
  const Vector2d u = travel(first, first.end_mm);
  const Vector2d v = travel(second, second.start_mm);
  EXPECT_EQ(u.x() * v.y() - u.y() * v.x() < 0, rounding.clockwise);
}

TEST(RoundCorner, RightAngleByHand) {
  const Rounding left = round_corner(line({0, 0}, {10, 0}), line({10, 0}, {10, 8}), 3);
  ASSERT_TRUE(left.has_value()) << left.error();
  EXPECT_THAT(left->start_mm, IsNearMatrix(Vector2d(7, 0), kExact_mm));
  EXPECT_THAT(left->end_mm, IsNearMatrix(Vector2d(10, 3), kExact_mm));
  EXPECT_THAT(left->center_mm, IsNearMatrix(Vector2d(7, 3), kExact_mm));
  EXPECT_FALSE(left->clockwise);
  const Rounding right = round_corner(line({0, 0}, {10, 0}), line({10, 0}, {10, -8}), 3);
  ASSERT_TRUE(right.has_value()) << right.error();
  EXPECT_THAT(right->center_mm, IsNearMatrix(Vector2d(7, -3), kExact_mm));
  EXPECT_TRUE(right->clockwise);
}

TEST(RoundCorner, LineIntoArcThatTurnsAwayByHand) {
  // Along y = 3 to (-4, 3) on the circle of radius 5 about 0, then over its top, clockwise. The
  // rounding of radius 5 is above the line and outside the circle: its centre (x, 8) is 10 from 0,
  // so x = -6. It touches the line below its centre and the circle halfway to 0.
  const ContourPiece first = line({-20, 3}, {-4, 3});
  const ContourPiece second = arc({-4, 3}, {5, 0}, {0, 0}, true);
  const Rounding rounding = round_corner(first, second, 5);
  ASSERT_TRUE(rounding.has_value()) << rounding.error();
  EXPECT_THAT(rounding->center_mm, IsNearMatrix(Vector2d(-6, 8), kExact_mm));
  EXPECT_THAT(rounding->start_mm, IsNearMatrix(Vector2d(-6, 3), kExact_mm));
  EXPECT_THAT(rounding->end_mm, IsNearMatrix(Vector2d(-3, 4), kExact_mm));
  EXPECT_FALSE(rounding->clockwise);
}

TEST(RoundCorner, LineIntoArcThatTurnsOnByHand) {
  // Along y = -3 to (4, -3) on the same circle, then on it counterclockwise. The rounding of radius
  // 3 is above the line, its centre (x, 0), and inside the circle, so x = 5 - 3.
  const ContourPiece first = line({-4, -3}, {4, -3});
  const ContourPiece second = arc({4, -3}, {-5, 0}, {0, 0}, false);
  const Rounding rounding = round_corner(first, second, 3);
  ASSERT_TRUE(rounding.has_value()) << rounding.error();
  EXPECT_THAT(rounding->center_mm, IsNearMatrix(Vector2d(2, 0), kExact_mm));
  EXPECT_THAT(rounding->start_mm, IsNearMatrix(Vector2d(2, -3), kExact_mm));
  EXPECT_THAT(rounding->end_mm, IsNearMatrix(Vector2d(5, 0), kExact_mm));
  EXPECT_FALSE(rounding->clockwise);
  // The circle of radius 4 touches at the top (0, 5), half a turn; no bigger one has room.
  EXPECT_TRUE(round_corner(first, second, 3.999).has_value());
  EXPECT_THAT(error_of(round_corner(first, second, 4.001)), HasSubstr("4.001"));
  EXPECT_THAT(error_of(round_corner(first, second, 6)), HasSubstr("radius 6"));
}

TEST(RoundCorner, ArcIntoLineByHand) {
  // The two cases above, travelled the other way.
  const Rounding away =
      round_corner(arc({5, 0}, {-4, 3}, {0, 0}, false), line({-4, 3}, {-20, 3}), 5);
  ASSERT_TRUE(away.has_value()) << away.error();
  EXPECT_THAT(away->start_mm, IsNearMatrix(Vector2d(-3, 4), kExact_mm));
  EXPECT_THAT(away->end_mm, IsNearMatrix(Vector2d(-6, 3), kExact_mm));
  EXPECT_THAT(away->center_mm, IsNearMatrix(Vector2d(-6, 8), kExact_mm));
  EXPECT_TRUE(away->clockwise);
  const Rounding on = round_corner(arc({-5, 0}, {4, -3}, {0, 0}, true), line({4, -3}, {-4, -3}), 3);
  ASSERT_TRUE(on.has_value()) << on.error();
  EXPECT_THAT(on->start_mm, IsNearMatrix(Vector2d(5, 0), kExact_mm));
  EXPECT_THAT(on->end_mm, IsNearMatrix(Vector2d(2, -3), kExact_mm));
  EXPECT_TRUE(on->clockwise);
}

TEST(RoundCorner, TouchesLinesWithContinuousTravel) {
  Random random(50);
  for (int trial = 0; trial < 500; ++trial) {
    SCOPED_TRACE(trial);
    const Vector2d corner(random.uniform(-100, 100), random.uniform(-100, 100));
    const double from = random.uniform(0, 2 * kPi);
    const double turn = random.uniform(0.05, 3) * (trial % 2 == 0 ? 1 : -1);
    const double radius = random.uniform(0.1, 10);
    const double needed = radius * std::tan(std::abs(turn) / 2);
    const ContourPiece first = line(on_circle(corner, needed * 1.01, from + kPi), corner);
    const ContourPiece second = line(corner, on_circle(corner, needed * 1.3, from + turn));
    const Rounding rounding = round_corner(first, second, radius);
    ASSERT_TRUE(rounding.has_value()) << rounding.error();
    expect_rounds(*rounding, first, second, radius);
    const ContourPiece short_first = line(on_circle(corner, needed * 0.99, from + kPi), corner);
    EXPECT_THAT(error_of(round_corner(short_first, second, radius)), HasSubstr("adjacent"));
    EXPECT_THAT(error_of(round_corner(reversed(second), reversed(short_first), radius)),
                HasSubstr("adjacent"));
  }
}

TEST(RoundCorner, TouchesLineAndArcWithContinuousTravel) {
  Random random(51);
  int n_rounded = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    SCOPED_TRACE(trial);
    const Vector2d center(random.uniform(-100, 100), random.uniform(-100, 100));
    const double arc_radius = random.uniform(1, 40);
    const double at = random.uniform(0, 2 * kPi);
    const bool clockwise = trial % 2 == 0;
    const double sweep = random.uniform(0.3, 6) * (clockwise ? -1 : 1);
    const Vector2d corner = on_circle(center, arc_radius, at);
    const ContourPiece second =
        arc(corner, on_circle(center, arc_radius, at + sweep), center, clockwise);
    const ContourPiece first =
        line(on_circle(corner, random.uniform(1, 60), random.uniform(0, 2 * kPi)), corner);
    const double radius = random.uniform(0.05, 6);
    const Rounding forth = round_corner(first, second, radius);
    const Rounding back = round_corner(reversed(second), reversed(first), radius);
    ASSERT_EQ(forth.has_value(), back.has_value());
    if (!forth) continue;
    ++n_rounded;
    expect_rounds(*forth, first, second, radius);
    expect_rounds(*back, reversed(second), reversed(first), radius);
    EXPECT_THAT(back->center_mm, IsNearMatrix(forth->center_mm, kExact_mm));
  }
  EXPECT_GT(n_rounded, 1000);
}

TEST(RoundCorner, SmallRoundingsStayInTheCorner) {
  // The smaller the radius, the nearer: within the tangent length of the two tangents at the
  // corner, r tan(turn / 2), and a little more for the arc's bend.
  Random random(52);
  for (int trial = 0; trial < 500; ++trial) {
    SCOPED_TRACE(trial);
    const double at = random.uniform(0, 2 * kPi);
    const Vector2d corner = on_circle({0, 0}, 20, at);
    const bool clockwise = trial % 2 == 0;
    const double turn = random.uniform(0.2, 2.5) * (trial % 4 < 2 ? 1 : -1);
    const Vector2d v = tangent(corner, {0, 0}, clockwise);
    const double out = std::atan2(v.y(), v.x());
    const ContourPiece first = line(on_circle(corner, 10, out - turn + kPi), corner);
    const ContourPiece second = arc(corner, on_circle({0, 0}, 20, at + kPi), {0, 0}, clockwise);
    const Rounding rounding = round_corner(first, second, 0.01);
    ASSERT_TRUE(rounding.has_value()) << rounding.error();
    const double straight = 0.01 * std::tan(std::abs(turn) / 2);
    EXPECT_NEAR((rounding->start_mm - corner).norm(), straight, 0.01 * straight);
    EXPECT_NEAR((rounding->end_mm - corner).norm(), straight, 0.01 * straight);
  }
}

TEST(RoundCorner, ArcsMayBeFullCirclesOrTooShort) {
  // Of the case by hand: the rounding ends at (-3, 4), 0.2838 rad after the corner.
  const ContourPiece first = line({-20, 3}, {-4, 3});
  EXPECT_TRUE(round_corner(first, arc({-4, 3}, {-4, 3}, {0, 0}, true), 5).has_value());
  const double corner = std::atan2(3, -4);
  const auto ending = [&](double angle) {
    return arc({-4, 3}, on_circle({0, 0}, 5, corner - angle), {0, 0}, true);
  };
  EXPECT_TRUE(round_corner(first, ending(0.284), 5).has_value());
  EXPECT_THAT(error_of(round_corner(first, ending(0.2837), 5)), HasSubstr("adjacent"));
  // The line is needed from (-6, 3) on.
  const ContourPiece second = ending(2);
  EXPECT_TRUE(round_corner(line({-6.01, 3}, {-4, 3}), second, 5).has_value());
  EXPECT_THAT(error_of(round_corner(line({-5.99, 3}, {-4, 3}), second, 5)),
              AllOf(HasSubstr("2 mm"), HasSubstr("1.99 mm")));
}

TEST(RoundCorner, RefusesWhatIsNoCorner) {
  const ContourPiece along = line({0, 0}, {10, 0});
  EXPECT_THAT(error_of(round_corner(along, line({10, 0}, {20, 0}), 1)), HasSubstr("straight"));
  EXPECT_THAT(error_of(round_corner(along, arc({10, 0}, {15, 5}, {10, 5}, false), 1)),
              HasSubstr("straight"));
  EXPECT_THAT(error_of(round_corner(along, line({10, 0}, {5, 0}), 1)), HasSubstr("back"));
  EXPECT_THAT(error_of(round_corner(along, line({10, 1}, {10, 5}), 1)), HasSubstr("1 mm"));
  EXPECT_THAT(error_of(round_corner(along, line({10, 0}, {10, 0}), 1)), HasSubstr("length"));
  EXPECT_THAT(error_of(round_corner(along, arc({10, 0}, {12, 0}, {10, 0}, true), 1)),
              HasSubstr("length"));
  const ContourPiece bow = arc({0, 0}, {10, 0}, {5, 0}, true);
  EXPECT_THAT(error_of(round_corner(bow, arc({10, 0}, {20, 0}, {15, 0}, true), 1)),
              HasSubstr("two arcs"));
  for (const double radius : {0.0, -1.0}) {
    EXPECT_THAT(error_of(round_corner(along, line({10, 0}, {10, 5}), radius)),
                HasSubstr("above 0"));
  }
  EXPECT_THAT(error_of(round_corner(along, line({10, 0}, {10, 5}), NAN)), HasSubstr("finite"));
  EXPECT_THAT(error_of(round_corner(along, line({10, 0}, {INFINITY, 5}), 1)), HasSubstr("finite"));
  // Finite numbers whose squares are not.
  EXPECT_FALSE(round_corner(line({0, 0}, {1e300, 0}), line({1e300, 0}, {1e300, 1e300}), 1e299));
  EXPECT_FALSE(round_corner(along, arc({10, 0}, {0, 1}, {1e300, 1e300}, true), 1));
}

}  // namespace
}  // namespace panelcal::sieb_meyer
