// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/figures/rout_figures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

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
using Figure = tl::expected<FigurePath, std::string>;

constexpr double kPi = std::numbers::pi;
constexpr double kExact_mm = 1e-9;     // roundings of doubles of some 100 mm
constexpr double kPrinted_mm = 0.001;  // the manual computes with 0.707 and cuts to 0.001 mm

FigurePath made(const Figure& figure) {
  if (!figure) ADD_FAILURE() << figure.error();
  return figure.value_or(FigurePath{});
}

std::string error_of(const Figure& figure) {
  return figure ? "no error" : figure.error();
}

/// Signed turn of an arc, counterclockwise positive; 0 for a line.
double sweep(const Arc& arc) {
  if (arc.straight) return 0;
  const Vector2d a = arc.start_mm - arc.center_mm;
  const Vector2d b = arc.end_mm - arc.center_mm;
  const double turn = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  if (arc.clockwise) return turn > 0 ? turn - 2 * kPi : turn;
  return turn < 0 ? turn + 2 * kPi : turn;
}

Vector2d point_at(const Arc& arc, double fraction) {
  if (arc.straight) return arc.start_mm + fraction * (arc.end_mm - arc.start_mm);
  const double angle = fraction * sweep(arc);
  const Vector2d spoke = arc.start_mm - arc.center_mm;
  return arc.center_mm + Vector2d(std::cos(angle) * spoke.x() - std::sin(angle) * spoke.y(),
                                  std::sin(angle) * spoke.x() + std::cos(angle) * spoke.y());
}

/// Of a piece at its start (fraction 0) or end (1), by a small step along it.
Vector2d direction_at(const Arc& arc, double fraction) {
  constexpr double kStep = 1e-6;
  return (point_at(arc, fraction + kStep) - point_at(arc, fraction - kStep)).normalized();
}

std::vector<Vector2d> samples(const FigurePath& path, double spacing) {
  std::vector<Vector2d> out;
  for (const Arc& piece : path.pieces) {
    const double length = piece.straight
                              ? (piece.end_mm - piece.start_mm).norm()
                              : std::abs(sweep(piece)) * (piece.start_mm - piece.center_mm).norm();
    const int n = 1 + static_cast<int>(length / spacing);
    for (int i = 0; i <= n; ++i) out.push_back(point_at(piece, static_cast<double>(i) / n));
  }
  return out;
}

void expect_chain(const FigurePath& path) {
  ASSERT_FALSE(path.pieces.empty());
  EXPECT_EQ(path.pieces.front().start_mm, path.plunge_mm);
  for (std::size_t i = 0; i < path.pieces.size(); ++i) {
    const Arc& piece = path.pieces[i];
    EXPECT_GT((piece.end_mm - piece.start_mm).norm(), 0);
    if (i > 0) {
      EXPECT_EQ(piece.start_mm, path.pieces[i - 1].end_mm) << i;
    }
    if (piece.straight) continue;
    EXPECT_NEAR((piece.start_mm - piece.center_mm).norm(),
                (piece.end_mm - piece.center_mm).norm(),
                kExact_mm);
    EXPECT_LE(std::abs(sweep(piece)), kPi + 1e-6);
  }
}

void expect_smooth(const FigurePath& path) {
  for (std::size_t i = 1; i < path.pieces.size(); ++i) {
    EXPECT_THAT(direction_at(path.pieces[i], 0),
                IsNearMatrix(direction_at(path.pieces[i - 1], 1), 1e-6))
        << i;
  }
}

double turned(const FigurePath& path) {
  double sum = 0;
  for (const Arc& piece : path.pieces) sum += sweep(piece);
  return sum;
}

// --- G45, G46 ------------------------------------------------------------------------------------

TEST(CircleInside, ManualPlungePoint) {
  const FigurePath g46 = made(circle_inside({35, 50}, 20, 2, Turn::Clockwise));
  EXPECT_THAT(g46.plunge_mm, IsNearMatrix(Vector2d(28.283, 66.217), kPrinted_mm));
  // 45 degrees up a circle of 9.5 mm that touches the path, of 19 mm, at its top.
  const double side = 9.5 / std::numbers::sqrt2;
  EXPECT_THAT(g46.plunge_mm, IsNearMatrix(Vector2d(35 - side, 50 + 9.5 + side), kExact_mm));
  const FigurePath g45 = made(circle_inside({35, 50}, 20, 2, Turn::Counterclockwise));
  EXPECT_THAT(g45.plunge_mm, IsNearMatrix(Vector2d(35 + side, 50 + 9.5 + side), kExact_mm));
}

TEST(CircleInside, PiecesByHand) {
  // r 20, FD 2: path radius 19, all round from the top; the approach about (0, 9.5).
  const double side = 9.5 / std::numbers::sqrt2;
  for (const Turn turn : {Turn::Counterclockwise, Turn::Clockwise}) {
    const bool clockwise = turn == Turn::Clockwise;
    const double sign = clockwise ? -1 : 1;
    const FigurePath path = made(circle_inside({0, 0}, 20, 2, turn));
    ASSERT_EQ(path.pieces.size(), 4U);
    const std::vector<Vector2d> ends = {{0, 19}, {0, -19}, {0, 19}, {-sign * side, 9.5 + side}};
    const std::vector<Vector2d> centers = {{0, 9.5}, {0, 0}, {0, 0}, {0, 9.5}};
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_THAT(path.pieces[i].end_mm, IsNearMatrix(ends[i], kExact_mm)) << i;
      EXPECT_THAT(path.pieces[i].center_mm, IsNearMatrix(centers[i], kExact_mm)) << i;
      EXPECT_EQ(path.pieces[i].clockwise, clockwise);
      EXPECT_FALSE(path.pieces[i].straight);
    }
  }
}

TEST(CircleInside, IsSmoothAndStaysInside) {
  Random random(45);
  for (int trial = 0; trial < 100; ++trial) {
    SCOPED_TRACE(trial);
    const double cutter = random.uniform(0.5, 4);
    const double radius = cutter / 2 + random.uniform(0.01, 30);
    const Vector2d center(random.uniform(-100, 100), random.uniform(-100, 100));
    const Turn turn = trial % 2 == 0 ? Turn::Clockwise : Turn::Counterclockwise;
    const FigurePath path = made(circle_inside(center, radius, cutter, turn));
    expect_chain(path);
    expect_smooth(path);
    const double eighths = turn == Turn::Clockwise ? -10 : 10;
    EXPECT_NEAR(turned(path), eighths * kPi / 4, 1e-6);
    double farthest = 0;
    for (const Vector2d& point : samples(path, radius / 50)) {
      farthest = std::max(farthest, (point - center).norm());
    }
    EXPECT_NEAR(farthest + cutter / 2, radius, kExact_mm);
  }
}

TEST(CircleInside, RefusesWhatDoesNotFit) {
  EXPECT_THAT(error_of(circle_inside({0, 0}, 1, 2, Turn::Clockwise)),
              AllOf(HasSubstr("1 mm"), HasSubstr("diameter of 2")));
  EXPECT_EQ(error_of(circle_inside({0, 0}, 1.001, 2, Turn::Clockwise)), "no error");
  EXPECT_THAT(error_of(circle_inside({0, 0}, 0, 2, Turn::Clockwise)), HasSubstr("0 mm"));
  EXPECT_THAT(error_of(circle_inside({0, 0}, -5, 2, Turn::Clockwise)), HasSubstr("-5 mm"));
  EXPECT_THAT(error_of(circle_inside({0, 0}, 5, 0, Turn::Clockwise)), HasSubstr("diameter"));
  EXPECT_THAT(error_of(circle_inside({NAN, 0}, 5, 1, Turn::Clockwise)), HasSubstr("finite"));
  EXPECT_THAT(error_of(circle_inside({0, 0}, 1e9, 1, Turn::Clockwise, Cut::Area)),
              HasSubstr("10000"));
}

// --- G47, G48 ------------------------------------------------------------------------------------

TEST(DiskOutside, ManualPlungePoint) {
  EXPECT_THAT(made(disk_outside({35, 50}, 20, 2, Turn::Counterclockwise)).plunge_mm,
              IsNearMatrix(Vector2d(14, 51), kExact_mm));
  EXPECT_THAT(made(disk_outside({35, 50}, 20, 2, Turn::Clockwise)).plunge_mm,
              IsNearMatrix(Vector2d(14, 49), kExact_mm));
}

TEST(DiskOutside, PiecesByHand) {
  const FigurePath path = made(disk_outside({35, 50}, 20, 2, Turn::Counterclockwise));
  ASSERT_EQ(path.pieces.size(), 4U);
  const std::vector<Vector2d> ends = {{14, 50}, {56, 50}, {14, 50}, {14, 49}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_THAT(path.pieces[i].end_mm, IsNearMatrix(ends[i], kExact_mm)) << i;
    EXPECT_EQ(path.pieces[i].straight, i == 0 || i == 3);
    EXPECT_FALSE(path.pieces[i].clockwise);
  }
}

TEST(DiskOutside, IsSmoothAndStaysOutside) {
  Random random(47);
  for (int trial = 0; trial < 100; ++trial) {
    SCOPED_TRACE(trial);
    const double cutter = random.uniform(0.5, 4);
    const double radius = random.uniform(0.01, 30);
    const Vector2d center(random.uniform(-100, 100), random.uniform(-100, 100));
    const Turn turn = trial % 2 == 0 ? Turn::Clockwise : Turn::Counterclockwise;
    const FigurePath path = made(disk_outside(center, radius, cutter, turn));
    expect_chain(path);
    expect_smooth(path);
    EXPECT_NEAR(turned(path), turn == Turn::Clockwise ? -2 * kPi : 2 * kPi, 1e-6);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vector2d& point : samples(path, radius / 50)) {
      nearest = std::min(nearest, (point - center).norm());
    }
    EXPECT_NEAR(nearest - cutter / 2, radius, kExact_mm);
  }
}

TEST(DiskOutside, RefusesBadNumbers) {
  EXPECT_THAT(error_of(disk_outside({0, 0}, 0, 2, Turn::Clockwise)), HasSubstr("0 mm"));
  EXPECT_THAT(error_of(disk_outside({0, 0}, 5, -2, Turn::Clockwise)), HasSubstr("-2 mm"));
  EXPECT_THAT(error_of(disk_outside({0, 0}, INFINITY, 2, Turn::Clockwise)), HasSubstr("finite"));
}

// --- G49, G50 ------------------------------------------------------------------------------------

TEST(RectangleInside, ManualPlungePoint) {
  for (const Turn turn : {Turn::Counterclockwise, Turn::Clockwise}) {
    EXPECT_THAT(made(rectangle_inside({30, 50}, {40, 30}, 2, turn)).plunge_mm,
                IsNearMatrix(Vector2d(30, 57), kExact_mm));
  }
}

TEST(RectangleInside, PiecesByHand) {
  // I40 J30 FD 2 about (30, 50): the path is 38 by 28.
  for (const Turn turn : {Turn::Counterclockwise, Turn::Clockwise}) {
    const FigurePath path = made(rectangle_inside({30, 50}, {40, 30}, 2, turn));
    expect_chain(path);
    const double a = turn == Turn::Clockwise ? 49 : 11;
    const double b = turn == Turn::Clockwise ? 11 : 49;
    const std::vector<Vector2d> ends = {
        {30, 64}, {a, 64}, {a, 36}, {b, 36}, {b, 64}, {30, 64}, {30, 57}};
    ASSERT_EQ(path.pieces.size(), ends.size());
    for (std::size_t i = 0; i < ends.size(); ++i) {
      EXPECT_THAT(path.pieces[i].end_mm, IsNearMatrix(ends[i], kExact_mm)) << i;
      EXPECT_TRUE(path.pieces[i].straight);
    }
  }
}

TEST(RectangleInside, RefusesWhatDoesNotFit) {
  EXPECT_THAT(error_of(rectangle_inside({0, 0}, {40, 2}, 2, Turn::Clockwise)),
              AllOf(HasSubstr("40 and 2 mm"), HasSubstr("diameter of 2")));
  EXPECT_THAT(error_of(rectangle_inside({0, 0}, {2, 40}, 2, Turn::Clockwise)),
              HasSubstr("diameter"));
  EXPECT_THAT(error_of(rectangle_inside({0, 0}, {0, 40}, 2, Turn::Clockwise)),
              AllOf(HasSubstr("side"), HasSubstr("0 mm")));
  EXPECT_THAT(error_of(rectangle_inside({0, 0}, {40, -1}, 2, Turn::Clockwise)), HasSubstr("-1 mm"));
  EXPECT_THAT(error_of(rectangle_inside({0, 0}, {40, 40}, 0, Turn::Clockwise)),
              AllOf(HasSubstr("diameter"), HasSubstr("0 mm")));
  EXPECT_THAT(error_of(rectangle_inside({0, 0}, {40, NAN}, 1, Turn::Clockwise)),
              HasSubstr("finite"));
  EXPECT_THAT(error_of(rectangle_inside({0, 0}, {1e9, 1e9}, 1, Turn::Clockwise, Cut::Area)),
              HasSubstr("10000"));
}

// --- G43 -----------------------------------------------------------------------------------------

/// Greatest distance of a grid of points from the path; the points are those of the figure whose
/// distance from its edge is at least `margin`, told by `is_inside`.
template <class Inside>
double worst_distance(const FigurePath& path, const Vector2d& half, double spacing, Inside inside) {
  const std::vector<Vector2d> way = samples(path, spacing / 4);
  double worst = 0;
  for (double x = -half.x(); x <= half.x(); x += spacing) {
    for (double y = -half.y(); y <= half.y(); y += spacing) {
      if (!inside(Vector2d(x, y))) continue;
      double nearest = std::numeric_limits<double>::infinity();
      for (const Vector2d& point : way) {
        nearest = std::min(nearest, (point - Vector2d(x, y)).norm());
      }
      worst = std::max(worst, nearest);
    }
  }
  return worst;
}

TEST(AreaClearing, CutsWholeCircles) {
  for (const double radius : {1.05, 1.5, 2.0, 2.7, 3.4, 3.5, 6.0, 11.3}) {
    SCOPED_TRACE(radius);
    const FigurePath path =
        made(circle_inside({0, 0}, radius, 2, Turn::Counterclockwise, Cut::Area));
    expect_chain(path);
    const double worst =
        worst_distance(path, {radius, radius}, radius / 40, [radius](const Vector2d& p) {
          return p.norm() <= radius;
        });
    EXPECT_LE(worst, 1 + 1e-3);  // the path is sampled
    for (const Vector2d& point : samples(path, 0.1)) EXPECT_LE(point.norm(), radius - 1 + 1e-9);
  }
}

TEST(AreaClearing, CutsWholeRectanglesButTheirCorners) {
  for (const Vector2d& sides : {Vector2d(2.1, 9), Vector2d(5, 3.3), Vector2d(8, 8)}) {
    SCOPED_TRACE(sides.transpose());
    const Vector2d half = sides / 2;
    const FigurePath path = made(rectangle_inside({0, 0}, sides, 2, Turn::Clockwise, Cut::Area));
    expect_chain(path);
    // A round cutter leaves what is outside the circle in each corner.
    const double worst = worst_distance(path, half, 0.08, [&half](const Vector2d& p) {
      const Vector2d beyond = (p.cwiseAbs() - half + Vector2d(1, 1)).cwiseMax(0);
      return beyond.norm() <= 1;
    });
    EXPECT_LE(worst, 1 + 1e-3);
    for (const Vector2d& point : samples(path, 0.1)) {
      EXPECT_LE((point.cwiseAbs() - half).maxCoeff(), -1 + 1e-9);
    }
  }
}

TEST(AreaClearing, CircleRingsByHand) {
  // r 7.4, FD 2: path radius 6.4; from 0.7 that is 5.7 / 1.4 = 4.07 steps, so five rings from 0.7
  // on and 1.14 mm apart.
  const FigurePath path = made(circle_inside({0, 0}, 7.4, 2, Turn::Clockwise, Cut::Area));
  const FigurePath plain = made(circle_inside({0, 0}, 7.4, 2, Turn::Clockwise));
  EXPECT_EQ(path.plunge_mm, plain.plunge_mm);
  ASSERT_EQ(path.pieces.size(), 5U * 3 + 1 + 4);
  for (std::size_t i = 0; i < 5; ++i) {
    const double radius = 0.7 + 1.14 * static_cast<double>(i);
    const Arc* ring = &path.pieces[3 * i];
    EXPECT_TRUE(ring[0].straight);
    EXPECT_THAT(ring[0].end_mm, IsNearMatrix(Vector2d(0, radius), kExact_mm));
    EXPECT_THAT(ring[1].end_mm, IsNearMatrix(Vector2d(0, -radius), kExact_mm));
    EXPECT_THAT(ring[2].end_mm, IsNearMatrix(Vector2d(0, radius), kExact_mm));
    EXPECT_TRUE(ring[1].clockwise && ring[2].clockwise);
  }
  EXPECT_TRUE(path.pieces[15].straight);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(path.pieces[16 + i].start_mm, plain.pieces[i].start_mm);
    EXPECT_EQ(path.pieces[16 + i].end_mm, plain.pieces[i].end_mm);
  }
}

TEST(AreaClearing, RectangleRingsByHand) {
  // 12 by 5 with FD 2: the path is 10 by 3; 1.5 - 0.7 = 0.8 is one step, so one ring inside,
  // 8.4 by 1.4. The plunge point is 0.75 above the centre.
  const FigurePath path = made(rectangle_inside({0, 0}, {12, 5}, 2, Turn::Clockwise, Cut::Area));
  const std::vector<Vector2d> ends = {{0, 0.7},
                                      {4.2, 0.7},
                                      {4.2, -0.7},
                                      {-4.2, -0.7},
                                      {-4.2, 0.7},
                                      {0, 0.7},
                                      {0, 1.5},
                                      {5, 1.5},
                                      {5, -1.5},
                                      {-5, -1.5},
                                      {-5, 1.5},
                                      {0, 1.5},
                                      {0, 0.75}};
  EXPECT_THAT(path.plunge_mm, IsNearMatrix(Vector2d(0, 0.75), kExact_mm));
  ASSERT_EQ(path.pieces.size(), ends.size());
  for (std::size_t i = 0; i < ends.size(); ++i) {
    EXPECT_THAT(path.pieces[i].end_mm, IsNearMatrix(ends[i], kExact_mm)) << i;
  }
}

TEST(AreaClearing, NeedsNoRingsInSmallFigures) {
  // Path radius, or half the path's shorter side, of at most 0.35 FD.
  EXPECT_EQ(made(circle_inside({0, 0}, 1.69, 2, Turn::Clockwise, Cut::Area)).pieces.size(), 4U);
  EXPECT_EQ(made(circle_inside({0, 0}, 1.71, 2, Turn::Clockwise, Cut::Area)).pieces.size(), 8U);
  EXPECT_EQ(made(rectangle_inside({0, 0}, {9, 3.39}, 2, Turn::Clockwise, Cut::Area)).pieces.size(),
            7U);
  // A plunge point that is on a ring's top already needs no line to it.
  EXPECT_EQ(made(rectangle_inside({0, 0}, {9, 4.8}, 2, Turn::Clockwise, Cut::Area)).pieces.size(),
            12U);
}

}  // namespace
}  // namespace panelcal::sieb_meyer
