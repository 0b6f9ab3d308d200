// SPDX-License-Identifier: Apache-2.0
// Arcs: CNC-7 manual, Circular Clockwise Move to Arc Center Offset; and under a correction.
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/program/excellon/interpreter/rout_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::center_inch;
using test::end_inch;
using test::expect_arc;
using test::FunctionSource;
using test::inch_t1;
using test::IsNearMatrix;
using test::kRounding_inch;
using test::kRounding_mm;
using test::metric_t1;
using test::ProgramRun;
using test::run_clean;
using test::run_program;
using test::says;
using test::steps;
using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::Not;

// --- CNC-7 manual: Circular Clockwise Move, Circular Counterclockwise Move -----------------------

TEST(RoutArc, ManualClockwiseExamples) {
  // The first arc is a quarter from the left of its centre to the top of it.
  const ProgramRun run = run_clean(
      inch_t1("G00X02375Y02025\nM15\nG02X0245Y021A00075\nX025567Y020567\nX0246Y0154A0015\nM17\n"));
  const std::vector<Rout>& arcs = run.executed.routs();
  ASSERT_EQ(arcs.size(), 3U);
  EXPECT_THAT(end_inch(arcs[0]), IsNearMatrix(Vector2d(2.45, 2.1), kRounding_inch));
  EXPECT_THAT(center_inch(arcs[0]), IsNearMatrix(Vector2d(2.45, 2.025), kRounding_inch));
  expect_arc(arcs[0], RoutKind::Clockwise, {2.375, 2.025}, 0.075);

  // Right of the chord: its middle and 0.048063 along (-0.376, -0.927).
  EXPECT_THAT(end_inch(arcs[1]), IsNearMatrix(Vector2d(2.5567, 2.0567), kRounding_inch));
  EXPECT_THAT(center_inch(arcs[1]), IsNearMatrix(Vector2d(2.485277, 2.033814), 1e-6));
  expect_arc(arcs[1], RoutKind::Clockwise, {2.45, 2.1}, 0.075);

  // 0.15 is below half the chord, 0.262835: the arc is adjusted to fit the coordinates.
  EXPECT_THAT(end_inch(arcs[2]), IsNearMatrix(Vector2d(2.46, 1.54), kRounding_inch));
  EXPECT_THAT(center_inch(arcs[2]), IsNearMatrix(Vector2d(2.50835, 1.79835), kRounding_inch));
  expect_arc(arcs[2], RoutKind::Clockwise, {2.5567, 2.0567}, std::hypot(0.0967, 0.5167) / 2);
  EXPECT_THAT(run.diagnostics, Contains(says(11, "warning[arc-adjusted]")));
  EXPECT_THAT(run.diagnostics, Not(Contains(says(10, "arc-adjusted"))));
}

TEST(RoutArc, ManualCounterclockwiseExamples) {
  // The first arc is a quarter from the right of its centre to the top of it.
  const ProgramRun run = run_clean(
      inch_t1("G00X02525Y02025\nM15\nG03X0245Y021A00075\nX025567Y020567\nX0246Y0154A0015\nM17\n"));
  const std::vector<Rout>& arcs = run.executed.routs();
  ASSERT_EQ(arcs.size(), 3U);
  EXPECT_THAT(center_inch(arcs[0]), IsNearMatrix(Vector2d(2.45, 2.025), kRounding_inch));
  expect_arc(arcs[0], RoutKind::Counterclockwise, {2.525, 2.025}, 0.075);
  // Left of the chord: the mirror image of the clockwise centre.
  EXPECT_THAT(center_inch(arcs[1]), IsNearMatrix(Vector2d(2.521423, 2.122886), 1e-6));
  expect_arc(arcs[1], RoutKind::Counterclockwise, {2.45, 2.1}, 0.075);
  EXPECT_THAT(center_inch(arcs[2]), IsNearMatrix(Vector2d(2.50835, 1.79835), kRounding_inch));
  EXPECT_EQ(arcs[2].kind, RoutKind::Counterclockwise);
  EXPECT_THAT(run.diagnostics, Contains(says(11, "warning[arc-adjusted]")));
}

TEST(RoutArc, TheRadiusMayStandAloneInAnEarlierBlock) {
  EXPECT_THAT(steps(run_clean(metric_t1("A10.\nG00X0.Y0.\nM15\nG02X10.Y10.\nM17\n"))),
              Contains("rout 1 cw (10, 10) about (10, 0)"));
}

TEST(RoutArc, TheCenterOffsetIsFromCenterToStart) {
  EXPECT_THAT(steps(run_clean(metric_t1("G00X0.Y0.\nM15\nG02X10.Y10.I-10.J0.\nM17\n"))),
              Contains("rout 1 cw (10, 10) about (10, 0)"));
  EXPECT_THAT(steps(run_clean(metric_t1("G00X0.Y0.\nM15\nG03X0.Y20.I0.J-10.\nM17\n"))),
              Contains("rout 1 ccw (0, 20) about (0, 10)"));
}

TEST(RoutArc, TheCenterOffsetMayHaveTheSignOfCamSystems) {
  EXPECT_THAT(steps(run_clean(metric_t1("G00X0.Y0.\nM15\nG02X10.Y10.I10.J0.\nM17\n"))),
              Contains("rout 1 cw (10, 10) about (10, 0)"));
  EXPECT_THAT(steps(run_clean(metric_t1("G00X0.Y0.\nM15\nG03X0.Y20.I0.J10.\nM17\n"))),
              Contains("rout 1 ccw (0, 20) about (0, 10)"));
}

TEST(RoutArc, TheCenterOffsetStaysInForce) {
  EXPECT_THAT(steps(run_clean(metric_t1(
                  "G00X0.Y0.\nM15\nG02X10.Y10.I-10.J0.\nX20.Y20.\nG01X30.Y20.\nG02X40.Y30.\n"
                  "M17\n"))),
              AllOf(Contains("rout 1 cw (20, 20) about (20, 10)"),
                    Contains("rout 1 cw (40, 30) about (40, 20)")));
}

TEST(RoutArc, TheLastGivenOfRadiusAndCenterOffsetRules) {
  EXPECT_THAT(steps(run_clean(metric_t1("G00X0.Y0.\nM15\nG02X10.Y10.A50.\nX20.Y20.I-10.J0.\n"
                                        "X40.Y40.A20.\nX60.Y60.\nM17\n"))),
              AllOf(Contains("rout 1 cw (20, 20) about (20, 10)"),
                    Contains("rout 1 cw (40, 40) about (40, 20)"),
                    Contains("rout 1 cw (60, 60) about (60, 40)")));
}

TEST(RoutArc, RadiiThatDifferByLessThanThreePercentAreAdjusted) {
  // From the centre (10, 0) it is 10 to the start and 10.2 to the end.
  const ProgramRun run = run_clean(metric_t1("G00X0.Y0.\nM15\nG02X10.Y10.2I-10.J0.\nM17\n"));
  EXPECT_THAT(run.diagnostics, Contains(says(9, "warning[arc-adjusted]")));
  ASSERT_EQ(run.executed.routs().size(), 1U);
  const Rout& arc = run.executed.routs()[0];
  const Vector2d& center_mm = arc.center.in_mm();
  EXPECT_EQ(arc.actual.in_mm(), Vector2d(10, 10.2));
  EXPECT_NEAR(center_mm.norm(), (arc.actual.in_mm() - center_mm).norm(), kRounding_mm);
  EXPECT_LT((center_mm - Vector2d(10, 0)).norm(), 0.2);
}

TEST(RoutArc, RadiiThatDifferByMoreThanThreePercentAreAnError) {
  EXPECT_THAT(run_program(metric_t1("G00X0.Y0.\nM15\nG02X10.Y10.5I-10.J0.\nM17\n")).diagnostics,
              Contains(says(9, "error[arc-invalid]")));
}

TEST(RoutArc, ExactArcsAreNotWarnedOf) {
  const ProgramRun run =
      run_clean(metric_t1("G00X0.Y0.\nM15\nG02X10.Y10.I-10.J0.\nX30.Y10.A10.\nM17\n"));
  EXPECT_THAT(run.diagnostics, Each(Not(HasSubstr("arc-"))));
}

TEST(RoutArc, MoreThanHalfACircleIsAnError) {
  for (const char* arc : {"G02X0.Y0.A10.",          // a full circle
                          "G03X0.Y0.I-10.J0.",      // a full circle
                          "G02X10.Y-10.I-10.J0."})  // three quarters
  {
    EXPECT_THAT(
        run_program(metric_t1("G00X0.Y0.\nM15\n" + std::string(arc) + "\nM17\n")).diagnostics,
        Contains(says(9, "error[arc-invalid]")))
        << arc;
  }
}

TEST(RoutArc, AnArcOfNoKnownRadiusIsAnError) {
  EXPECT_THAT(run_program(metric_t1("G00X0.Y0.\nM15\nG02X10.Y10.\nM17\n")).diagnostics,
              Contains(says(9, "error[")));
}

// --- arcs under a measured correction ------------------------------------------------------------

/// A panel on which every target is seen where this map carries it.
FunctionSource mapped(const Eigen::Matrix2d& linear, const Vector2d& shift_mm) {
  return FunctionSource([=](const MeasurementRequest& request) -> Vector2d {
    return linear * request.nominal.in_mm() + shift_mm;
  });
}

TEST(CorrectedArc, StaysOneArcUnderARotation) {
  const double angle_rad = std::asin(0.01);
  const Eigen::Matrix2d rotation = Eigen::Rotation2Dd(angle_rad).toRotationMatrix();
  FunctionSource panel = mapped(rotation, {0.5, -0.2});
  WalkOptions options;
  options.series_size = 2;
  const ProgramRun run = run_program(
      metric_t1("G34,1\nG36X0.Y0.\nG36X100.Y0.\nG00X100.Y50.\nM15\nG03X50.Y100.A50.\nM17\n"),
      options,
      panel);
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  ASSERT_EQ(run.executed.routs().size(), 1U);
  const Rout& arc = run.executed.routs()[0];
  const Vector2d end_mm = rotation * Vector2d(50, 100) + Vector2d(0.5, -0.2);
  const Vector2d center_mm = rotation * Vector2d(50, 50) + Vector2d(0.5, -0.2);
  EXPECT_EQ(arc.kind, RoutKind::Counterclockwise);
  EXPECT_THAT(arc.corrected.in_mm(), IsNearMatrix(end_mm, kRounding_mm));
  EXPECT_THAT(arc.corrected_center.in_mm(), IsNearMatrix(center_mm, kRounding_mm));
  EXPECT_NEAR((arc.corrected.in_mm() - arc.corrected_center.in_mm()).norm(), 50, kRounding_mm);
}

constexpr double kStretchX = 1.001;
constexpr double kStretchY = 0.998;

ProgramRun stretched_quarter_circle(const WalkOptions& options) {
  FunctionSource panel =
      mapped(Vector2d(kStretchX, kStretchY).asDiagonal().toDenseMatrix(), {0.5, 0});
  return run_program(metric_t1("G34,1\nG36X0.Y0.\nG36X100.Y0.\nG36X0.Y100.\nG00X100.Y50.\nM15\n"
                               "G03X50.Y100.A50.\nM17\n"),
                     options,
                     panel);
}

/// Points of a piece that begins at `start_mm`, in corrected coordinates.
std::vector<Vector2d> points_along(const Vector2d& start_mm, const Rout& piece) {
  constexpr int kPoints = 2000;
  const Vector2d& end_mm = piece.corrected.in_mm();
  const Vector2d& center_mm = piece.corrected_center.in_mm();
  const Vector2d from = start_mm - center_mm;
  const Vector2d to = end_mm - center_mm;
  const double turn_rad = std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
  std::vector<Vector2d> points;
  for (int i = 0; i <= kPoints; ++i) {
    const double part = static_cast<double>(i) / kPoints;
    if (piece.kind == RoutKind::Line) {
      points.emplace_back(start_mm + part * (end_mm - start_mm));
    } else {
      points.emplace_back(center_mm + Eigen::Rotation2Dd(part * turn_rad) * from);
    }
  }
  return points;
}

TEST(CorrectedArc, IsSplitWithinTheToleranceOfTheEllipse) {
  for (const Length tolerance : {um(1), um(10)}) {
    WalkOptions options;
    options.arc_tolerance = tolerance;
    const ProgramRun run = stretched_quarter_circle(options);
    ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
    const std::vector<Rout>& pieces = run.executed.routs();
    ASSERT_GT(pieces.size(), 1U);
    Vector2d start_mm(kStretchX * 100 + 0.5, kStretchY * 50);
    double last_angle_rad = -1e-9;
    for (const Rout& piece : pieces) {
      EXPECT_NE(piece.kind, RoutKind::Clockwise);
      for (const Vector2d& p_mm : points_along(start_mm, piece)) {
        // On the unstretched panel the contour is the circle of 50 about (50, 50). Stretching adds
        // at most a thousandth to a distance there.
        const Vector2d back_mm((p_mm.x() - 0.5) / kStretchX, p_mm.y() / kStretchY);
        const Vector2d ray_mm = back_mm - Vector2d(50, 50);
        EXPECT_LE(std::abs(ray_mm.norm() - 50), 1.005 * tolerance.in_mm() + kRounding_mm);
        const double angle_rad = std::atan2(ray_mm.y(), ray_mm.x());
        EXPECT_GE(angle_rad, last_angle_rad - 1e-9);
        last_angle_rad = angle_rad;
      }
      start_mm = piece.corrected.in_mm();
    }
    EXPECT_THAT(start_mm,
                IsNearMatrix(Vector2d(kStretchX * 50 + 0.5, kStretchY * 100), kRounding_mm));
  }
}

TEST(CorrectedArc, StaysOneArcWithinAWideTolerance) {
  WalkOptions options;
  options.arc_tolerance = mm(0.5);
  const ProgramRun run = stretched_quarter_circle(options);
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  ASSERT_EQ(run.executed.routs().size(), 1U);
  EXPECT_EQ(run.executed.routs()[0].kind, RoutKind::Counterclockwise);
}

}  // namespace
}  // namespace panelcal
