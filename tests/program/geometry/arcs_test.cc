// SPDX-License-Identifier: Apache-2.0
#include "program/geometry/arcs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"
#include "calib/base/units.h"
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using test::IsNearMatrix;

constexpr double kPi = std::numbers::pi;
constexpr double kExact_mm = 1e-12;  // a few roundings of doubles of some mm
constexpr double kRounding_mm = 0.001;

Vector2d inches(double x, double y) {
  return {inch(x).in_mm(), inch(y).in_mm()};
}

Vector2d on_circle(const Vector2d& center, double radius, double angle) {
  return center + radius * Vector2d(std::cos(angle), std::sin(angle));
}

Matrix2d rotation(double angle) {
  return (Matrix2d() << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle))
      .finished();
}

/// Signed turn from start to end, 0 to 2 pi in size.
double sweep(const Arc& arc) {
  const Vector2d a = arc.start_mm - arc.center_mm;
  const Vector2d b = arc.end_mm - arc.center_mm;
  const double turn = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  if (arc.clockwise) return turn > 0 ? turn - 2 * kPi : turn;
  return turn < 0 ? turn + 2 * kPi : turn;
}

Vector2d point_at(const Arc& arc, double fraction) {
  if (arc.straight) return arc.start_mm + fraction * (arc.end_mm - arc.start_mm);
  return arc.center_mm + rotation(fraction * sweep(arc)) * (arc.start_mm - arc.center_mm);
}

double distance_to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const double length2 = (b - a).squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(b - a) / length2, 0.0, 1.0) : 0;
  return (p - a - t * (b - a)).norm();
}

double distance_to_arc(const Vector2d& p, const Arc& arc) {
  if (arc.straight) return distance_to_segment(p, arc.start_mm, arc.end_mm);
  Arc part = arc;
  part.end_mm = p;
  if (std::abs(sweep(part)) <= std::abs(sweep(arc))) {
    return std::abs((p - arc.center_mm).norm() - (arc.start_mm - arc.center_mm).norm());
  }
  return std::min((p - arc.start_mm).norm(), (p - arc.end_mm).norm());
}

struct Map {
  Matrix2d linear = Matrix2d::Identity();
  Vector2d translation = Vector2d::Zero();
  Vector2d operator()(const Vector2d& p) const { return linear * p + translation; }
};

/// The greatest distance of `n` points of the true image from the pieces, and the other way round.
double hausdorff(const Arc& arc, const Map& map, const std::vector<Arc>& pieces, int n) {
  std::vector<Vector2d> image;
  for (int i = 0; i <= n; ++i) image.push_back(map(point_at(arc, i / static_cast<double>(n))));
  double worst = 0;
  for (const Vector2d& p : image) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Arc& piece : pieces) nearest = std::min(nearest, distance_to_arc(p, piece));
    worst = std::max(worst, nearest);
  }
  for (const Arc& piece : pieces) {
    for (int i = 0; i <= 20; ++i) {
      const Vector2d p = point_at(piece, i / 20.0);
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t k = 1; k < image.size(); ++k) {
        nearest = std::min(nearest, distance_to_segment(p, image[k - 1], image[k]));
      }
      worst = std::max(worst, nearest);
    }
  }
  return worst;
}

/// An arc of `turn` radians (negative: clockwise) about a centre.
Arc arc_about(const Vector2d& center, double radius, double from, double turn) {
  return {
      on_circle(center, radius, from), on_circle(center, radius, from + turn), center, turn < 0};
}

void expect_chain(const std::vector<Arc>& pieces, const Arc& arc, const Map& map) {
  ASSERT_FALSE(pieces.empty());
  EXPECT_LE(pieces.size(), 4096U);
  EXPECT_EQ(pieces.front().start_mm, map(arc.start_mm));
  EXPECT_EQ(pieces.back().end_mm, map(arc.end_mm));
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    EXPECT_EQ(pieces[i].start_mm, pieces[i - 1].end_mm);
  }
  for (const Arc& piece : pieces) {
    EXPECT_EQ(piece.clockwise, arc.clockwise != (map.linear.determinant() < 0));
    if (piece.straight) continue;
    EXPECT_LE(std::abs(sweep(piece)), kPi + 1e-6);
    EXPECT_NEAR((piece.start_mm - piece.center_mm).norm(),
                (piece.end_mm - piece.center_mm).norm(),
                1e-9 * (1 + (piece.start_mm - piece.center_mm).norm()));
  }
}

// --- radius --------------------------------------------------------------------------------------

TEST(ArcFromRadius, ManualClockwiseMove) {
  // Example 2 of G02: from 2.45, 2.1 to 2.5567, 2.0567 with a radius of 0.075 inch.
  const ArcFit fit = arc_from_radius(
      inches(2.45, 2.1), inches(2.5567, 2.0567), inch(0.075).in_mm(), true, inch(1e-4).in_mm());
  EXPECT_EQ(fit.fault, ArcFault::None);
  EXPECT_EQ(fit.adjusted_mm, 0);
  EXPECT_THAT(fit.arc.center_mm, IsNearMatrix(inches(2.485277, 2.033814), inch(2e-6).in_mm()));
  EXPECT_TRUE(fit.arc.clockwise);
}

TEST(ArcFromRadius, ManualCounterclockwiseMoveHasTheCentreOnTheOtherSide) {
  const ArcFit fit = arc_from_radius(
      inches(2.45, 2.1), inches(2.5567, 2.0567), inch(0.075).in_mm(), false, inch(1e-4).in_mm());
  EXPECT_THAT(fit.arc.center_mm, IsNearMatrix(inches(2.521423, 2.122886), inch(2e-6).in_mm()));
  EXPECT_FALSE(fit.arc.clockwise);
}

TEST(ArcFromRadius, ManualThirdExampleIsAdjustedToHalfTheChord) {
  // From 2.5567, 2.0567 to 2.46, 1.54 the half chord is 0.262835 inch, the radius only 0.15.
  const ArcFit fit = arc_from_radius(
      inches(2.5567, 2.0567), inches(2.46, 1.54), inch(0.15).in_mm(), true, inch(1e-4).in_mm());
  EXPECT_EQ(fit.fault, ArcFault::None);
  EXPECT_NEAR(fit.adjusted_mm, inch(0.112835).in_mm(), inch(1e-6).in_mm());
  EXPECT_THAT(fit.arc.center_mm, IsNearMatrix(inches(2.50835, 1.79835), kExact_mm));
}

TEST(ArcFromRadius, RightOfTheChordForClockwise) {
  // 3, 4, 5: the centre is 4 mm beside the chord of 6 mm.
  EXPECT_THAT(arc_from_radius({0, 0}, {6, 0}, 5, true, kRounding_mm).arc.center_mm,
              IsNearMatrix(Vector2d(3, -4), kExact_mm));
  EXPECT_THAT(arc_from_radius({0, 0}, {6, 0}, 5, false, kRounding_mm).arc.center_mm,
              IsNearMatrix(Vector2d(3, 4), kExact_mm));
}

TEST(ArcFromRadius, AdjustmentWithinRoundingIsNotTold) {
  EXPECT_EQ(arc_from_radius({0, 0}, {6, 0}, 2.9991, true, kRounding_mm).adjusted_mm, 0);
  EXPECT_NEAR(arc_from_radius({0, 0}, {6, 0}, 2.998, true, kRounding_mm).adjusted_mm, 0.002, 1e-12);
  EXPECT_EQ(arc_from_radius({0.1, 0.2}, {0.4, 0.6}, 0.25, true, 0).adjusted_mm, 0);
  EXPECT_EQ(arc_from_radius({0, 0}, {6, 0}, 0, true, kRounding_mm).adjusted_mm, 3);
}

TEST(ArcFromRadius, RefusesWhatIsNoArc) {
  EXPECT_EQ(arc_from_radius({1, 2}, {1, 2}, 5, true, kRounding_mm).fault, ArcFault::NoChord);
  EXPECT_EQ(arc_from_radius({1, 2}, {1, 2}, 5, true, 0).fault, ArcFault::NoChord);
  EXPECT_EQ(arc_from_radius({1, 2}, {1.0004, 2}, 5, true, kRounding_mm).fault, ArcFault::NoChord);
  EXPECT_EQ(arc_from_radius({999.999, 2}, {1000, 2}, 5, true, kRounding_mm).fault, ArcFault::None);
  EXPECT_EQ(arc_from_radius({0, 0}, {6, 0}, -5, true, 0).fault, ArcFault::RadiusMismatch);
  EXPECT_EQ(arc_from_radius({0, 0}, {6, 0}, NAN, true, 0).fault, ArcFault::RadiusMismatch);
  EXPECT_EQ(arc_from_radius({0, 0}, {NAN, 0}, 5, true, 0).fault, ArcFault::RadiusMismatch);
  EXPECT_EQ(arc_from_radius({0, 0}, {INFINITY, 0}, 5, true, 0).fault, ArcFault::RadiusMismatch);
}

TEST(ArcFromRadius, HugeRadiusKeepsItsSagitta) {
  const ArcFit fit = arc_from_radius({0, 0}, {2, 0}, 1e6, false, kRounding_mm);
  EXPECT_NEAR(1e6 - fit.arc.center_mm.y(), 0.5e-6, 1e-9);
}

// --- centre offset -------------------------------------------------------------------------------

TEST(ArcFromCenterOffset, TakesBothSigns) {
  for (const double sign : {1.0, -1.0}) {  // start - centre, centre - start
    const ArcFit quarter =
        arc_from_center_offset({13, 4}, {3, 14}, {sign * 10, 0}, false, kRounding_mm);
    EXPECT_EQ(quarter.fault, ArcFault::None);
    EXPECT_EQ(quarter.adjusted_mm, 0);
    EXPECT_THAT(quarter.arc.center_mm, IsNearMatrix(Vector2d(3, 4), kExact_mm));
    const ArcFit half =
        arc_from_center_offset({13, 4}, {-7, 4}, {sign * 10, 0}, true, kRounding_mm);
    EXPECT_EQ(half.fault, ArcFault::None);
    EXPECT_THAT(half.arc.center_mm, IsNearMatrix(Vector2d(3, 4), kExact_mm));
  }
}

TEST(ArcFromCenterOffset, ShortArcsOfBigCirclesTakeTheRightSide) {
  // Both signs fit within 3 %: only the side tells them apart.
  const Vector2d end = on_circle({0, 0}, 10, 0.1);
  for (const double sign : {1.0, -1.0}) {
    const ArcFit fit = arc_from_center_offset({10, 0}, end, {sign * 10, 0}, false, kRounding_mm);
    EXPECT_EQ(fit.fault, ArcFault::None);
    EXPECT_EQ(fit.adjusted_mm, 0);
    EXPECT_THAT(fit.arc.center_mm, IsNearMatrix(Vector2d(0, 0), 1e-9));
  }
}

TEST(ArcFromCenterOffset, RefusesMoreThanHalfACircle) {
  for (const double sign : {1.0, -1.0}) {
    const ArcFit fit = arc_from_center_offset({10, 0}, {0, 10}, {sign * 10, 0}, true, kRounding_mm);
    EXPECT_EQ(fit.fault, ArcFault::RadiusMismatch);
    EXPECT_NEAR(fit.adjusted_mm, 0, kExact_mm);
    EXPECT_THAT(fit.arc.center_mm, IsNearMatrix(Vector2d(0, 0), kExact_mm));
    // 354 degrees: the other sign would fit within 3 %, but this one fits exactly.
    EXPECT_EQ(arc_from_center_offset(
                  {10, 0}, on_circle({0, 0}, 10, 0.1), {sign * 10, 0}, true, kRounding_mm)
                  .fault,
              ArcFault::RadiusMismatch);
  }
}

TEST(ArcFromCenterOffset, AdjustsUpToThreePercent) {
  const ArcFit fit = arc_from_center_offset({10, 0}, {0, 10.2}, {10, 0}, false, kRounding_mm);
  EXPECT_EQ(fit.fault, ArcFault::None);
  EXPECT_THAT(fit.arc.center_mm, IsNearMatrix(Vector2d(-0.0990, 0.1010), 1e-4));
  EXPECT_NEAR(fit.adjusted_mm, 0.0995, 1e-4);
  EXPECT_NEAR((fit.arc.start_mm - fit.arc.center_mm).norm(),
              (fit.arc.end_mm - fit.arc.center_mm).norm(),
              1e-12);
  const ArcFit refused = arc_from_center_offset({10, 0}, {0, 10.4}, {10, 0}, false, kRounding_mm);
  EXPECT_EQ(refused.fault, ArcFault::RadiusMismatch);
  EXPECT_NEAR(refused.adjusted_mm, 0.4, kExact_mm);
}

TEST(ArcFromCenterOffset, RefusesAChordThatPointsAtTheCentre) {
  // The radii differ by 1 % only, but no circle about anywhere near has both points.
  EXPECT_EQ(arc_from_center_offset({100, 0}, {101, 0.01}, {100, 0}, false, kRounding_mm).fault,
            ArcFault::RadiusMismatch);
}

TEST(ArcFromCenterOffset, RadiiThatAgreeWithinRoundingAreNotAdjusted) {
  // Over a chord of 4 steps the centre moves by 56 mm, but not one point of the path by a step.
  const ArcFit fit =
      arc_from_center_offset({100, 0}, {100.002, 0.003}, {100, 0}, false, kRounding_mm);
  EXPECT_EQ(fit.fault, ArcFault::None);
  EXPECT_EQ(fit.adjusted_mm, 0);
  EXPECT_LE(distance_to_segment(point_at(fit.arc, 0.5), fit.arc.start_mm, fit.arc.end_mm), 1e-6);
}

TEST(ArcFromCenterOffset, RefusesWhatIsNoArc) {
  const auto fault = [](const Vector2d& end, const Vector2d& ij) {
    return arc_from_center_offset({1, 2}, end, ij, false, kRounding_mm).fault;
  };
  EXPECT_EQ(fault({1, 2}, {5, 0}), ArcFault::NoChord);  // a whole circle
  EXPECT_EQ(fault({4, 2}, {0, 0}), ArcFault::RadiusMismatch);
  EXPECT_EQ(fault({4, 2}, {NAN, 0}), ArcFault::RadiusMismatch);
  EXPECT_EQ(fault({4, INFINITY}, {1, 0}), ArcFault::RadiusMismatch);
}

Vector2d rounded(const Vector2d& v, double step) {
  return {std::round(v.x() / step) * step, std::round(v.y() / step) * step};
}

TEST(ArcFromCenterOffset, NumbersRoundedByTheFileStillFit) {
  Random random(11);
  for (int trial = 0; trial < 4000; ++trial) {
    SCOPED_TRACE(trial);
    const double step_mm = trial % 2 == 0 ? 0.001 : inch(1e-4).in_mm();
    const double radius_mm = std::exp(random.uniform(std::log(0.1), std::log(300.0)));
    // Half of them are as near half a circle as the roundings are.
    const double turn = trial % 4 < 2 ? kPi : random.uniform(20 * step_mm / radius_mm, kPi);
    const Vector2d center(random.uniform(-300, 300), random.uniform(-300, 300));
    const Arc truth =
        arc_about(center, radius_mm, random.uniform(0, 2 * kPi), trial % 8 < 4 ? turn : -turn);
    const Vector2d ij = rounded(truth.start_mm - center, step_mm);
    const ArcFit fit = arc_from_center_offset(rounded(truth.start_mm, step_mm),
                                              rounded(truth.end_mm, step_mm),
                                              trial % 16 < 8 ? ij : Vector2d(-ij),
                                              truth.clockwise,
                                              step_mm);
    ASSERT_EQ(fit.fault, ArcFault::None);
    EXPECT_LE(fit.adjusted_mm, 2 * step_mm);
    for (int i = 0; i <= 50; ++i) {
      ASSERT_LE(distance_to_arc(point_at(truth, i / 50.0), fit.arc), 3 * step_mm);
    }
  }
}

// --- under a map ---------------------------------------------------------------------------------

TEST(CarryArc, SimilarityKeepsOneArc) {
  const Arc arc = arc_about({3, 4}, 10, 0.3, 2);
  const Map map{1.0005 * rotation(0.7), {100, -50}};
  const std::vector<Arc> pieces = carry_arc(arc, map.linear, map.translation, 0);
  ASSERT_EQ(pieces.size(), 1U);
  expect_chain(pieces, arc, map);
  EXPECT_THAT(pieces[0].center_mm, IsNearMatrix(map(arc.center_mm), kExact_mm));
}

TEST(CarryArc, MirrorFlipsTheSense) {
  const Matrix2d mirror = Vector2d(-1, 1).asDiagonal();
  const std::vector<Arc> pieces = carry_arc({{1, 0}, {0, 1}, {0, 0}, false}, mirror, {5, 0}, 0);
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_TRUE(pieces[0].clockwise);
  EXPECT_EQ(pieces[0].start_mm, Vector2d(4, 0));
  EXPECT_EQ(pieces[0].end_mm, Vector2d(5, 1));
  EXPECT_EQ(pieces[0].center_mm, Vector2d(5, 0));
}

TEST(CarryArc, QuarterCircleUnderAStretchByHand) {
  // x = 1.01 cos, y = sin. The circle through (1.01, 0), (0.714178, 0.707107) and (0, 1) has its
  // centre at (0.004975, -0.005025) and is up to 0.000842 beside the ellipse.
  const Map map{Vector2d(1.01, 1).asDiagonal(), {0, 0}};
  const Arc arc = arc_about({0, 0}, 1, 0, kPi / 2);
  const std::vector<Arc> one = carry_arc(arc, map.linear, map.translation, 0.0012);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_THAT(one[0].center_mm, IsNearMatrix(Vector2d(0.004975, -0.005025), 1e-6));
  EXPECT_EQ(carry_arc(arc, map.linear, map.translation, 0.0008).size(), 2U);
}

TEST(CarryArc, HalfCirclesStayOneArcUnderASmallStretch) {
  // Squeezed across the chord or along it: the second would make a bit more than half a circle.
  for (const Vector2d& stretch : {Vector2d(1, 1.0001), Vector2d(1.0001, 1)}) {
    const Arc arc = arc_about({0, 0}, 5, 0, kPi);
    const Map map{stretch.asDiagonal(), {0, 0}};
    const std::vector<Arc> pieces = carry_arc(arc, map.linear, map.translation, 0.002);
    ASSERT_EQ(pieces.size(), 1U);
    expect_chain(pieces, arc, map);
    EXPECT_LE(hausdorff(arc, map, pieces, 2000), 0.002);
  }
}

TEST(CarryArc, KeepsItsPromiseUnderRandomCorrections) {
  Random random(21);
  std::size_t n_split = 0;
  for (int trial = 0; trial < 400; ++trial) {
    SCOPED_TRACE(trial);
    const double radius = std::exp(random.uniform(std::log(0.01), std::log(1000.0)));
    const double turn = trial % 5 == 0 ? kPi : trial % 5 == 1 ? kPi / 2 : random.uniform(1e-3, kPi);
    const Arc arc = arc_about({random.uniform(-300, 300), random.uniform(-300, 300)},
                              radius,
                              random.uniform(0, 2 * kPi),
                              trial % 2 == 0 ? turn : -turn);
    const double stretch = std::pow(10, random.uniform(-5, -3));
    const Vector2d scales(1 + stretch, trial % 3 == 0 ? -1 : 1 - stretch);
    const Map map{
        rotation(random.uniform(0, 6)) * scales.asDiagonal() * rotation(random.uniform(0, 6)),
        {random.uniform(-10, 10), random.uniform(-10, 10)}};
    const double tolerance = std::pow(10, random.uniform(-5, -2));
    const std::vector<Arc> pieces = carry_arc(arc, map.linear, map.translation, tolerance);
    expect_chain(pieces, arc, map);
    n_split += pieces.size() > 1;
    // The reference is a polygon: its own sagitta, and the digits of coordinates of some 1000 mm.
    const double slack = radius * std::pow(turn / 1000, 2) / 8 + 1e-10;
    EXPECT_LE(hausdorff(arc, map, pieces, 1000), tolerance + slack);
  }
  EXPECT_GT(n_split, 50U);
}

TEST(CarryArc, TheTrueImageIsWithinToleranceToTheLastDigit) {
  Random random(22);
  for (int trial = 0; trial < 300; ++trial) {
    SCOPED_TRACE(trial);
    const Arc arc =
        arc_about({0, 0}, random.uniform(1, 100), random.uniform(0, 6), random.uniform(0.1, kPi));
    const double ratio = std::pow(10, random.uniform(-4, 0));
    const Map map{rotation(random.uniform(0, 6)) * Vector2d(1, 1 - 0.99 * ratio).asDiagonal() *
                      rotation(random.uniform(0, 6)),
                  {0, 0}};
    const double tolerance = std::pow(10, random.uniform(-6, -1));
    const std::vector<Arc> pieces = carry_arc(arc, map.linear, map.translation, tolerance);
    expect_chain(pieces, arc, map);
    double worst = 0;
    for (int i = 0; i <= 4000; ++i) {
      const Vector2d p = map(point_at(arc, i / 4000.0));
      double nearest = std::numeric_limits<double>::infinity();
      for (const Arc& piece : pieces) nearest = std::min(nearest, distance_to_arc(p, piece));
      worst = std::max(worst, nearest);
      if (pieces.size() > 64) i += 9;  // so many pieces need fewer points each
    }
    EXPECT_LE(worst, tolerance + 1e-12);
  }
}

TEST(CarryArc, DoesNotSplitMuchMoreThanItMust) {
  Random random(23);
  for (int trial = 0; trial < 100; ++trial) {
    const Arc arc = arc_about({0, 0}, 20, random.uniform(0, 6), random.uniform(0.5, 3.1));
    const Map map{Vector2d(1.002, 1).asDiagonal(), {0, 0}};
    const std::vector<Arc> one = carry_arc(arc, map.linear, map.translation, 10);
    ASSERT_EQ(one.size(), 1U);
    const double deviation = hausdorff(arc, map, one, 1000);
    EXPECT_EQ(carry_arc(arc, map.linear, map.translation, 2.2 * deviation + 1e-5).size(), 1U);
  }
}

TEST(CarryArc, StrongDistortionsHoldToo) {
  Random random(24);
  for (int trial = 0; trial < 60; ++trial) {
    SCOPED_TRACE(trial);
    const Arc arc = arc_about({1, 2}, 1, random.uniform(0, 6), random.uniform(0.3, kPi));
    const Matrix2d shear = (Matrix2d() << 1, random.uniform(-3, 3), 0, 1).finished();
    const Map map{rotation(random.uniform(0, 6)) *
                      Vector2d(1, std::pow(10, random.uniform(-3, 0))).asDiagonal() * shear,
                  {0, 0}};
    const std::vector<Arc> pieces = carry_arc(arc, map.linear, map.translation, 0.001);
    expect_chain(pieces, arc, map);
    EXPECT_LT(pieces.size(), 200U);
    EXPECT_LE(hausdorff(arc, map, pieces, 4000), 0.001 + 1e-6);
  }
}

TEST(CarryArc, TinyAndHugeArcs) {
  const Matrix2d stretch = Vector2d(1.001, 0.999).asDiagonal();
  for (const double radius : {1e-6, 1e-3, 1e5, 1e9}) {
    const Arc arc = arc_about({0, 0}, radius, 1, 2);
    const std::vector<Arc> pieces = carry_arc(arc, stretch, {0, 0}, 1e-3);
    expect_chain(pieces, arc, {stretch, {0, 0}});
  }
  // Ten mm of a circle of a hundred km: flat, but not straight; of 10^9 km: straight.
  const Arc flat = arc_from_radius({0, 0}, {10, 3}, 1e8, true, 0).arc;
  ASSERT_EQ(carry_arc(flat, stretch, {0, 0}, 1e-3).size(), 1U);
  EXPECT_FALSE(carry_arc(flat, stretch, {0, 0}, 1e-3)[0].straight);
  const Arc line = arc_from_radius({0, 0}, {10, 3}, 1e15, true, 0).arc;
  for (const Matrix2d& map : {stretch, Matrix2d(Matrix2d::Identity())}) {
    const std::vector<Arc> pieces = carry_arc(line, map, {0, 0}, 1e-3);
    ASSERT_EQ(pieces.size(), 1U);
    EXPECT_TRUE(pieces[0].straight);
    EXPECT_EQ(pieces[0].center_mm, Vector2d(map * Vector2d(5, 1.5)));
  }
}

TEST(CarryArc, SingularMapsGiveLinesThatGoThereAndBack) {
  // The half circle about (0, 0) from (0, -5) over (5, 0) to (0, 5), pressed onto the x axis.
  const Arc arc = arc_about({0, 0}, 5, -kPi / 2, kPi);
  const Map map{Vector2d(1, 0).asDiagonal(), {0, 1}};
  const std::vector<Arc> pieces = carry_arc(arc, map.linear, map.translation, 0.001);
  ASSERT_FALSE(pieces.empty());
  double reach = 0;
  for (const Arc& piece : pieces) {
    EXPECT_TRUE(piece.straight);
    EXPECT_EQ(piece.start_mm.y(), 1);
    reach = std::max(reach, piece.end_mm.x());
  }
  EXPECT_NEAR(reach, 5, 0.001);
  EXPECT_EQ(carry_arc(arc, Matrix2d::Zero(), {1, 2}, 0.001).size(), 1U);
}

TEST(CarryArc, NothingMakesItLoop) {
  const Arc arc = arc_about({0, 0}, 5, 0, 3);
  const Matrix2d stretch = Vector2d(1.1, 1).asDiagonal();
  for (const double tolerance : {0.0, -1.0, 1e-300, static_cast<double>(NAN)}) {
    EXPECT_EQ(carry_arc(arc, stretch, {0, 0}, tolerance).size(), 4096U);
  }
  for (const double bad : {static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    const Matrix2d linear = Vector2d(bad, 1).asDiagonal();
    const std::vector<Arc> pieces = carry_arc(arc, linear, {0, 0}, 0.001);
    ASSERT_EQ(pieces.size(), 1U);
    EXPECT_TRUE(pieces[0].straight);
  }
  for (const double huge : {1e100, 1e160, 1e300, 1e-160, 1e-300}) {
    EXPECT_LE(carry_arc(arc, huge * stretch, {0, 0}, 0.001).size(), 4096U);
  }
  const std::vector<Arc> no_chord =
      carry_arc({{1, 0}, {1, 0}, {0, 0}, true}, stretch, {0, 0}, 0.001);
  ASSERT_EQ(no_chord.size(), 1U);
  EXPECT_TRUE(no_chord[0].straight);
}

}  // namespace
}  // namespace panelcal
