// SPDX-License-Identifier: Apache-2.0
// SIEB & MEYER manual, chapter 3 (Routing) and 8.5 (I and J).
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;
using test::ended;
using test::expect_places;
using test::format_5000;
using test::IsNearMatrix;
using test::Piece;
using test::pieces_from;
using test::ProgramRun;
using test::rout_ends;
using test::run_5000;
using test::run_program;
using test::says;
using test::steps_of;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

using Lines = std::vector<std::string>;

constexpr double kRounding_mm = 1e-6;
constexpr double kMmPerSOfOneMPerMin = 1000.0 / 60;

void expect_arc(const Piece& piece,
                RoutKind kind,
                const Vector2d& end_mm,
                const Vector2d& center_mm,
                double sweep_rad) {
  EXPECT_EQ(piece.kind, kind);
  EXPECT_THAT(piece.end_mm, IsNearMatrix(end_mm, kRounding_mm));
  EXPECT_THAT(piece.center_mm, IsNearMatrix(center_mm, kRounding_mm));
  EXPECT_NEAR(piece.sweep_rad, sweep_rad, 1e-6);
}

// --- chapter 3.1: G1, G2, G3 ---------------------------------------------------------------------

TEST(ManualG1, TwoStraightLines) {
  const ProgramRun run = run_5000("X10.Y50.T5 T0\nX50.Y20.G1 F1.\nX90.Y60.\nX90.Y60.T0\n");
  EXPECT_THAT(run.executed.lines(),
              ElementsAre("2 tool 5",
                          "2 position (10, 50)",
                          "3 plunge",
                          "3 rout 5 line (50, 20)",
                          "4 rout 5 line (90, 60)",
                          "5 retract"));
  EXPECT_NEAR(run.executed.routs()[0].feed.in_mm_s(), kMmPerSOfOneMPerMin, 1e-9);
}

/// "If at least one of the two XY-coordinates is not defined the last valid X-value and/or Y-value
/// applies."
TEST(ManualG1, AnOmittedAxisKeepsItsValue) {
  EXPECT_THAT(steps_of(run_5000("X10.Y50.T5T0\nX50.G1F1.\nY20.\nX50.Y20.T0\n")),
              ElementsAre("tool 5",
                          "position (10, 50)",
                          "plunge",
                          "rout 5 line (50, 50)",
                          "rout 5 line (50, 20)",
                          "retract"));
}

/// R15. is the short way, R-15. the long one; the third arc has no R, so R-15. stays in force.
TEST(ManualG2G3, ContourOfThreeArcs) {
  const ProgramRun run =
      run_5000("X30.Y50.T0 T5\nX40.Y50.G2 R15. F1.2\nX50.Y50.R-15.\nX60.Y50.G3\nX60.Y50.T0\n");
  const std::vector<Piece> pieces = pieces_from({30, 50}, run.executed.routs());
  ASSERT_EQ(pieces.size(), 3U);
  const double height_mm = std::sqrt(15.0 * 15 - 5 * 5);
  const double short_way_rad = 2 * std::asin(5.0 / 15);
  const double long_way_rad = 2 * pi - short_way_rad;
  // Clockwise and short: the centre lies to the right of the chord; every change changes the side.
  expect_arc(pieces[0], RoutKind::Clockwise, {40, 50}, {35, 50 - height_mm}, short_way_rad);
  expect_arc(pieces[1], RoutKind::Clockwise, {50, 50}, {45, 50 + height_mm}, long_way_rad);
  expect_arc(pieces[2], RoutKind::Counterclockwise, {60, 50}, {55, 50 - height_mm}, long_way_rad);
  EXPECT_NEAR(run.executed.routs()[0].feed.in_mm_s(), 1.2 * kMmPerSOfOneMPerMin, 1e-9);
}

/// "If the value is positive, the routing angle is <= 180 degrees": R of half the chord is allowed.
TEST(ManualG2G3, PositiveRadiusOfHalfTheChordIsASemicircle) {
  const ProgramRun run = run_5000("X30.Y50.T0T5\nX40.Y50.G2R5.F1.\nX50.Y50.G3\nX50.Y50.T0\n");
  const std::vector<Piece> pieces = pieces_from({30, 50}, run.executed.routs());
  ASSERT_EQ(pieces.size(), 2U);
  expect_arc(pieces[0], RoutKind::Clockwise, {40, 50}, {35, 50}, pi);
  expect_arc(pieces[1], RoutKind::Counterclockwise, {50, 50}, {45, 50}, pi);
}

/// M80 mirrors around the X-axis, so the router goes round the other way.
TEST(ManualG2G3, AMirroredArcChangesItsSense) {
  const ProgramRun run =
      run_5000("X30.Y50.T0T5M31\nX40.Y60.G2R10.F1.G42\nX40.Y60.T0\nXY200.M80M30\n");
  ASSERT_EQ(run.executed.routs().size(), 1U);
  EXPECT_EQ(run.executed.routs()[0].kind, RoutKind::Counterclockwise);
  // Clockwise from (30, 50) to (40, 60) is about (40, 50).
  EXPECT_THAT(run.executed.routs()[0].center.in_mm(), IsNearMatrix(Vector2d(40, 150), 1e-6));
  EXPECT_THAT(steps_of(run), Contains("compensation left 2.0000 [0]"));
}

// --- chapter 3.2: G40, G42 -----------------------------------------------------------------------

TEST(ManualG42, SlotsWithAndWithoutCompensation) {
  const ProgramRun run = run_5000(
      "X10.Y50.T5 T0\nX50.Y30.G1 G42 F1.2\nX60.Y55.G40\nX50.Y30.\nX85.Y45.G42\nX85.Y45.T0\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 5",
                          "position (10, 50)",
                          "compensation right 2.0000",
                          "plunge",
                          "rout 5 line (50, 30)",
                          "compensation off",
                          "rout 5 line (60, 55)",
                          "rout 5 line (50, 30)",
                          "compensation right 2.0000",
                          "rout 5 line (85, 45)",
                          "retract"));
}

/// "The cutter radius compensation remains on until the T0 command."
TEST(ManualG42, EndsWithItsContour) {
  const ProgramRun run =
      run_5000("X10.Y50.T5T0\nX50.Y50.G1G41F1.2\nX50.Y50.T0\nX10.Y70.T0\nX50.Y70.G1\nX50.Y70.T0\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 5",
                          "position (10, 50)",
                          "compensation left 2.0000",
                          "plunge",
                          "rout 5 line (50, 50)",
                          "retract",
                          "position (10, 70)",
                          "plunge",
                          "rout 5 line (50, 70)",
                          "retract"));
}

// --- chapter 3.3: D ------------------------------------------------------------------------------

/// The manual's listing lacks the arc's R; a right angle between straight lines can be worked out.
TEST(ManualD, RoundsARightAngle) {
  const ProgramRun run = run_5000("X10.Y50.T0T5\nX70.Y50.G1D20. F1.2\nX70.Y130.\nX70.Y130.T0\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 5",
                          "position (10, 50)",
                          "plunge",
                          "rout 5 line (50, 50)",
                          "rout 5 ccw (70, 70) about (50, 70)",
                          "rout 5 line (70, 130)",
                          "retract"));
}

/// "The routing function 'Rounding edge' is only effective for the program line in which it was
/// programmed."
TEST(ManualD, HoldsForItsLineOnly) {
  const ProgramRun run = run_5000("XYT0T5\nX50.YG1D10.F1.\nX50.Y50.\nXY50.\nXY50.T0\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 5",
                          "position (0, 0)",
                          "plunge",
                          "rout 5 line (40, 0)",
                          "rout 5 ccw (50, 10) about (40, 10)",
                          "rout 5 line (50, 50)",
                          "rout 5 line (0, 50)",
                          "retract"));
}

/// The manual's contour with R300., for which there is room to round: an arc of 20 mm that touches
/// both neighbours.
TEST(ManualD, RoundsThePassageFromAnArcToALine) {
  const ProgramRun run =
      run_5000("X10.Y50.T0T5\nX70.Y40.G2R300.D20. F1.2\nX30.Y130.G1\nX30.Y130.T0\n");
  const ProgramRun sharp =
      run_5000("X10.Y50.T0T5\nX70.Y40.G2R300. F1.2\nX30.Y130.G1\nX30.Y130.T0\n");
  const std::vector<Piece> pieces = pieces_from({10, 50}, run.executed.routs());
  const std::vector<Piece> edge = pieces_from({10, 50}, sharp.executed.routs());
  ASSERT_EQ(pieces.size(), 3U);
  ASSERT_EQ(edge.size(), 2U);
  EXPECT_EQ(pieces[0].kind, RoutKind::Clockwise);
  EXPECT_EQ(pieces[1].kind, RoutKind::Counterclockwise);
  EXPECT_EQ(pieces[2].kind, RoutKind::Line);
  EXPECT_THAT(pieces[0].center_mm, IsNearMatrix(edge[0].center_mm, kRounding_mm));
  EXPECT_LT(pieces[0].sweep_rad, edge[0].sweep_rad);
  EXPECT_NEAR(pieces[1].radius_mm(), 20, kRounding_mm);
  for (const std::size_t joint : {0U, 1U}) {
    const Vector2d& p_mm = pieces[joint].end_mm;
    EXPECT_THAT(pieces[joint].direction_at(p_mm),
                IsNearMatrix(pieces[joint + 1].direction_at(p_mm), 1e-6))
        << "joint " << joint;
  }
  EXPECT_THAT(pieces[2].direction_at(pieces[2].end_mm),
              IsNearMatrix(edge[1].direction_at(edge[1].end_mm), 1e-6));
}

// --- chapter 3.3: F ------------------------------------------------------------------------------

/// The listing's drilling lines between the contours are X60.Y40.T1 and X30.Y40.; it has T6 for the
/// second contour.
TEST(ManualF, FeedStaysActiveForAllContours) {
  const ProgramRun run = run_5000(
      "X30.Y60.T0 T5\nX60.Y30.G1 F2.\nX60.Y30.T0\nX60.Y40.T1\nX30.Y40.\n"
      "X30.Y30.T0 T6\nX60.Y60.G1\nX60.Y60.T0\n");
  ASSERT_EQ(run.executed.routs().size(), 2U);
  for (const Rout& rout : run.executed.routs()) {
    EXPECT_NEAR(rout.feed.in_mm_s(), 2 * kMmPerSOfOneMPerMin, 1e-9);
    EXPECT_FALSE(rout.feed_is_default);
  }
  EXPECT_EQ(run.executed.routs()[1].tool, 6);
  EXPECT_EQ(run.holes().size(), 2U);
}

/// "If no routing feed rate is programmed the machine routs at the default routing feed rate."
TEST(ManualF, MissingFeedIsTheMachinesDefault) {
  const ProgramRun run = run_5000("XYT0T5\nX10.YG1\nX10.YT0\n");
  ASSERT_EQ(run.executed.routs().size(), 1U);
  EXPECT_TRUE(run.executed.routs()[0].feed_is_default);
}

double feed_mm_s(const std::string& text) {
  const ProgramRun run = run_program(ended(text));
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  if (run.executed.routs().size() != 1) return -1;
  return run.executed.routs()[0].feed.in_mm_s();
}

TEST(ManualF, UnitDependsOnTheFormat) {
  const double expected = 1.5 * kMmPerSOfOneMPerMin;
  EXPECT_NEAR(feed_mm_s("%%\nX1000Y1000T1T0\nX2000Y1000G1F15\nX2000Y1000T0\n"), expected, 1e-9);
  EXPECT_NEAR(feed_mm_s("%%3000\nX10.Y10.T1T0\nX20.Y10.G1F15\nX20.Y10.T0\n"), expected, 1e-9);
  EXPECT_NEAR(feed_mm_s("%%5000\nX10.Y10.T1T0\nX20.Y10.G1F1500\nX20.Y10.T0\n"), expected, 1e-9);
  EXPECT_NEAR(feed_mm_s("%%5000\nX10.Y10.T1T0\nX20.Y10.G1F1.5\nX20.Y10.T0\n"), expected, 1e-9);
}

// --- chapter 3.3: G6, G11 ------------------------------------------------------------------------

/// The listing's `Z3.5.` has a point too many.
TEST(ManualG6, RampFromTwoToThreeAndAHalf) {
  const ProgramRun run = run_5000(
      "X10.Y10.T1 Z1.0\nX20.Y40.T0T2Z2.0\nX70.Y40.G1F.8 G6Z3.5\nX70.Y40. T0\nX10.Y20.T3Z1.0\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 1",
                          "drill 1 (10, 10) z 1",
                          "tool 2",
                          "position (20, 40)",
                          "plunge z 2",
                          "rout 2 line (70, 40) z 3.5",
                          "retract",
                          "tool 3",
                          "drill 3 (10, 20) z 1"));
  EXPECT_NEAR(run.executed.routs()[0].feed.in_mm_s(), 0.8 * kMmPerSOfOneMPerMin, 1e-9);
}

/// "The programmed Z-target plane remains active until the next Z-command, which means that the
/// following holes are also drilled up to the new Z-plane."
TEST(ManualG6, ItsPlaneStaysActiveForHoles) {
  const ProgramRun run =
      run_5000("X20.Y40.T0T2Z2.0\nX70.Y40.G1F.8G6Z3.5\nX70.Y40.T0\nX10.Y20.T3\n");
  EXPECT_EQ(run.executed.lines().back(), "5 drill 3 (10, 20) z 3.5");
}

/// The listing's third line has no G1, but its chord is longer than the arc's 2 R.
TEST(ManualG11, FinishRoutingStandsBeforeItsTrack) {
  const ProgramRun run =
      run_5000("X50.Y50.T0T2\nX70.Y50.G2R10. F1.2\nX110.Y90.G1G11\nX110.Y90.T0\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 2",
                          "position (50, 50)",
                          "plunge",
                          "rout 2 cw (70, 50) about (60, 50)",
                          "function finish_routing G11",
                          "rout 2 line (110, 90)",
                          "retract"));
}

// --- chapters 3.4 and 3.5: several contours ------------------------------------------------------

TEST(ManualContours, TwoContours) {
  const ProgramRun run =
      run_program(ended("%%5000\n(1. CONTOUR)\nX100.Y100.T0T5\nX110.Y100.G1F1.5\nX110.Y100.T0\n"
                        "(2. CONTOUR)\nX200.Y200.T0\nX220.Y200.G1\nX220.Y200.T0\n"));
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 5",
                          "position (100, 100)",
                          "plunge",
                          "rout 5 line (110, 100)",
                          "retract",
                          "position (200, 200)",
                          "plunge",
                          "rout 5 line (220, 200)",
                          "retract"));
  for (const Rout& rout : run.executed.routs()) {
    EXPECT_NEAR(rout.feed.in_mm_s(), 1.5 * kMmPerSOfOneMPerMin, 1e-9);
  }
}

TEST(ManualContours, ConnectedContours) {
  const ProgramRun run =
      run_5000("X100.Y100.T5T0\nX150.Y100.G3R25.F1.5\nX200.Y100.G1\nX200.Y150.\nX200.Y150.T0\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 5",
                          "position (100, 100)",
                          "plunge",
                          "rout 5 ccw (150, 100) about (125, 100)",
                          "rout 5 line (200, 100)",
                          "rout 5 line (200, 150)",
                          "retract"));
}

// --- chapter 8.5: I and J ------------------------------------------------------------------------

/// I = X_start - X_center = 20 - 50, J = 80 - 55; the end is 38.08 mm from that centre, the start
/// 39.05 mm: within 3 % the arc is adjusted, with a warning.
TEST(ManualIJ, ArcOfTheManualIsAdjusted) {
  const ProgramRun run =
      run_program(ended("%%3000\nX20.Y80.T5T0\nX65.Y20.G2I-30.J25.F12\nX65.Y20.T0\n"));
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(run.diagnostics, Contains(says(3, "warning[")));
  const std::vector<Piece> pieces = pieces_from({20, 80}, run.executed.routs());
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_EQ(pieces[0].kind, RoutKind::Clockwise);
  EXPECT_THAT(pieces[0].end_mm, IsNearMatrix(Vector2d(65, 20), kRounding_mm));
  constexpr double kAdjustment_mm = 1;  // the radii differ by 0.97 mm
  EXPECT_THAT(pieces[0].center_mm, IsNearMatrix(Vector2d(50, 55), kAdjustment_mm));
  // From 140.2 degrees clockwise to -66.8 degrees.
  EXPECT_NEAR(pieces[0].sweep_rad, 207.0 * pi / 180, 0.05);
}

TEST(ManualIJ, AnExactArcIsNotAdjusted) {
  const ProgramRun run =
      run_program(ended("%%3000\nX20.Y80.T5T0\nX80.Y80.G3I-30.J25.F12\nX80.Y80.T0\n"));
  EXPECT_THAT(run.diagnostics, testing::Not(Contains(says(3, ""))));
  const std::vector<Piece> pieces = pieces_from({20, 80}, run.executed.routs());
  ASSERT_EQ(pieces.size(), 1U);
  expect_arc(
      pieces[0], RoutKind::Counterclockwise, {80, 80}, {50, 55}, 2 * pi - 2 * std::atan2(30, 25));
}

/// "No negative signs must be programmed in the format 1000. Furthermore, a separate program line
/// must [be] programmed for each quadrant of the circular arc."
TEST(ManualIJ, Format1000HasPositiveValuesAndOneQuadrantALine) {
  const ProgramRun clockwise = run_program(
      ended("%%\nX3000Y5000T5T0\nX5000Y7000G2I2000J0F15\nX7000Y5000G2I0J2000\nX5000Y3000G2I2000J0\n"
            "X5000Y3000T0\n"));
  EXPECT_FALSE(clockwise.has_errors) << testing::PrintToString(clockwise.diagnostics);
  const std::vector<Piece> right = pieces_from({30, 50}, clockwise.executed.routs());
  ASSERT_EQ(right.size(), 1U) << "three quadrants of one circle";
  expect_arc(right[0], RoutKind::Clockwise, {50, 30}, {50, 50}, 1.5 * pi);

  const ProgramRun counterclockwise = run_program(
      ended("%%\nX3000Y5000T5T0\nX5000Y3000G3I2000J0F15\nX7000Y5000G3I0J2000\nX7000Y5000T0\n"));
  EXPECT_FALSE(counterclockwise.has_errors) << testing::PrintToString(counterclockwise.diagnostics);
  const std::vector<Piece> left = pieces_from({30, 50}, counterclockwise.executed.routs());
  ASSERT_EQ(left.size(), 1U);
  expect_arc(left[0], RoutKind::Counterclockwise, {70, 50}, {50, 50}, pi);
}

/// "Internally in the CNC the routing and peck drilling parameters are organized in different
/// variables. Thus, the last settings remain active."
TEST(ManualIJ, PeckParametersLeaveThoseOfRoutingAlone) {
  const ProgramRun run = run_5000(
      "XYT0T5\nX20.Y20.G49I10.J6.F1.\nX20.Y20.T0\nX50.Y50.T1G81I5.P80J1.4W1000\n"
      "X80.Y20.T0T5G80\nX80.Y20.G49\nX80.Y20.T0\n");
  const test::Places ends = rout_ends(run);
  ASSERT_EQ(ends.size() % 2, 0U);
  const auto half = static_cast<std::ptrdiff_t>(ends.size() / 2);
  expect_places(test::Places(ends.begin() + half, ends.end()),
                test::shifted({ends.begin(), ends.begin() + half}, Vector2d(60, 0)));
}

}  // namespace
}  // namespace panelcal
