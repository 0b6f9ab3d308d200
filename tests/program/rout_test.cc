// SPDX-License-Identifier: Apache-2.0
// Routing: CNC-7 manual, Rout Mode to Retract without Clamping, Routed Circle Canned Cycle, Routed
// Step Slot Canned Cycle.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FunctionSource;
using test::inch_leading_zeros;
using test::IsNearMatrix;
using test::metric;
using test::ProgramRun;
using test::run_program;
using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

using Lines = std::vector<std::string>;

constexpr double kRounding_inch = 1e-9;
constexpr double kRounding_mm = 1e-9;

/// A diagnostic of this line of the program, with `what` in its text.
auto says(int line, const std::string& what) {
  return AllOf(StartsWith("p.exc:" + std::to_string(line) + ":"), HasSubstr(what));
}

ProgramRun run_clean(std::string text, const WalkOptions& options = {}) {
  ProgramRun run = run_program(std::move(text), options);
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  return run;
}

/// `body` behind T1 in line 6, before M30.
std::string metric_t1(std::string_view body) {
  return metric("T1\n" + std::string(body) + "M30\n");
}
std::string inch_t1(std::string_view body) {
  return inch_leading_zeros("T1\n" + std::string(body) + "M30\n");
}

/// What is done in the body, without line numbers and settings.
Lines steps(const ProgramRun& run) {
  Lines out;
  for (const std::string& line : run.executed.lines()) {
    std::string what = line.substr(line.find(' ') + 1);
    if (!what.starts_with("setting") && what != "header_end") out.push_back(std::move(what));
  }
  return out;
}

Vector2d end_inch(const Rout& rout) {
  return rout.nominal.in_mm() / kMmPerInch;
}
Vector2d center_inch(const Rout& rout) {
  return rout.center.in_mm() / kMmPerInch;
}

/// An arc of this radius and sense, at most half a circle, from a place to where `rout` ends.
void expect_arc(const Rout& rout, RoutKind kind, const Vector2d& start_inch, double radius_inch) {
  EXPECT_EQ(rout.kind, kind);
  const Vector2d from = start_inch - center_inch(rout);
  const Vector2d to = end_inch(rout) - center_inch(rout);
  EXPECT_NEAR(from.norm(), radius_inch, kRounding_inch);
  EXPECT_NEAR(to.norm(), radius_inch, kRounding_inch);
  const double left_turn = from.x() * to.y() - from.y() * to.x();
  const double turn = kind == RoutKind::Clockwise ? -left_turn : left_turn;
  EXPECT_GE(turn, -kRounding_inch);
}

// --- CNC-7 manual: Rout Mode, Linear Move, plunge and retract ------------------------------------

TEST(Rout, MovesPlungesRoutsAndRetracts) {
  const ProgramRun run = run_clean(metric_t1(
      "G00X10.Y10.\nM15\nG01X20.\nY20.\nM17\nG00X30.Y30.\nM15\nG01X40.Y30.\nM16\nG05\nX5.Y5.\n"));
  EXPECT_EQ(steps(run),
            (Lines{"tool 1",
                   "position (10, 10)",
                   "plunge",
                   "rout 1 line (20, 10)",
                   "rout 1 line (20, 20)",
                   "retract",
                   "position (30, 30)",
                   "plunge",
                   "rout 1 line (40, 30)",
                   "retract clamping",
                   "drill 1 (5, 5)",
                   "end rewind"}));
}

TEST(Rout, OperationsCarryTheirLines) {
  const ProgramRun run = run_clean(metric_t1("G00X10.Y10.\nM15\nG01X20.\nM17\n"));
  for (const char* line :
       {"7 position (10, 10)", "8 plunge", "9 rout 1 line (20, 10)", "10 retract"}) {
    EXPECT_THAT(run.executed.lines(), Contains(line));
  }
}

TEST(Rout, G00StaysInForceForMoves) {
  EXPECT_EQ(
      steps(run_clean(metric_t1("G00X10.Y10.\nX20.\nY30.\n"))),
      (Lines{
          "tool 1", "position (10, 10)", "position (20, 10)", "position (20, 30)", "end rewind"}));
}

TEST(Rout, AModeWithoutCoordinatesLooksForThemInASucceedingBlock) {
  EXPECT_EQ(steps(run_clean(metric_t1(
                "G00X0.Y0.\nM15\nG01\nX10.Y0.\nG02A10.\nX20.Y10.\nG03\nX30.Y20.\nM17\n"))),
            (Lines{"tool 1",
                   "position (0, 0)",
                   "plunge",
                   "rout 1 line (10, 0)",
                   "rout 1 cw (20, 10) about (20, 0)",
                   "rout 1 ccw (30, 20) about (20, 20)",
                   "retract",
                   "end rewind"}));
}

TEST(Rout, M14PlungesWithDepthControlledContouring) {
  EXPECT_THAT(steps(run_clean(metric_t1("G00X0.Y0.\nM14\nG01X10.Y0.\nM16\n"))),
              AllOf(Contains("plunge contouring"), Contains("retract clamping")));
}

TEST(Rout, IncrementalCoordinatesCountFromTheLastMove) {
  const ProgramRun run =
      run_clean(metric_t1("G91\nG00X10.Y10.\nM15\nG01X5.\nG03X5.Y5.A5.\nM17\nG05\nX1.Y1.\n"));
  EXPECT_THAT(steps(run),
              AllOf(Contains("rout 1 line (15, 10)"),
                    Contains("rout 1 ccw (20, 15) about (15, 15)"),
                    Contains("drill 1 (21, 16)")));
}

TEST(Rout, AMoveWhileTheRouterIsUpIsAnError) {
  for (const char* move : {"G01X20.Y0.\n", "G02X20.Y0.A10.\n", "G03X20.Y0.I-10.J0.\n"}) {
    EXPECT_THAT(run_program(metric_t1(std::string("G00X0.Y0.\n") + move)).diagnostics,
                Contains(says(8, "error[rout-not-plunged]")))
        << move;
  }
  EXPECT_THAT(run_program(metric_t1("G00X0.Y0.\nM15\nG01X10.Y0.\nM17\nX20.Y0.\n")).diagnostics,
              Contains(says(11, "error[rout-not-plunged]")));
}

TEST(Rout, WhatMustNotHappenWhilePlungedIsAnError) {
  for (const char* block : {"G00X10.Y10.", "G40", "G41", "G42", "T2", "G05", "M30"}) {
    EXPECT_THAT(run_program(metric("T1\nG00X0.Y0.\nM15\n" + std::string(block) + "\nM17\nM30\n"))
                    .diagnostics,
                Contains(says(9, "error[tool-plunged]")))
        << block;
  }
}

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

// --- CNC-7 manual: Cutter Compensation -----------------------------------------------------------

/// On which side compensation is whenever the router goes down.
Lines sides_at_plunges(const ProgramRun& run) {
  const std::string compensation = "compensation ";
  Lines sides;
  std::string side = "off";
  for (const std::string& step : steps(run)) {
    if (step.starts_with(compensation)) {
      side = step.substr(compensation.size());
      side = side.substr(0, side.find(' '));
    }
    if (step.starts_with("plunge")) sides.push_back(side);
  }
  return sides;
}

TEST(Compensation, IsSwitchedRightBeforeThePlunge) {
  const Lines done = steps(run_clean(metric_t1("G00X0.Y0.\nG41\nM15\nG01X10.Y0.\nM17\n")));
  const auto plunge = std::ranges::find(done, "plunge");
  ASSERT_TRUE(plunge != done.end() && plunge != done.begin());
  EXPECT_THAT(*(plunge - 1), StartsWith("compensation left"));
  EXPECT_EQ(*(plunge + 1), "rout 1 line (10, 0)");
}

TEST(Compensation, EndsWithG00AndG40) {
  const std::string contour = "M15\nG01X10.Y0.\nM17\n";
  EXPECT_EQ(sides_at_plunges(run_clean(metric_t1("G00X0.Y0.\nG41\n" + contour + "G00X0.Y20.\n" +
                                                 contour + "G00X0.Y40.\nG42\n" + contour +
                                                 "G00X0.Y60.\nG42\nG40\n" + contour))),
            (Lines{"left", "off", "right", "off"}));
  EXPECT_EQ(sides_at_plunges(run_clean(metric_t1("G41\nG00X0.Y0.\n" + contour))), Lines{"off"});
}

TEST(Compensation, IsNeverSwitchedWhilePlunged) {
  bool is_down = false;
  for (const std::string& step : steps(run_clean(
           metric_t1("G00X0.Y0.\nG41\nM15\nG01X10.Y0.\nM17\nG00X0.Y9.\nM15\nG01X9.Y9.\nM17\n")))) {
    is_down = (is_down || step.starts_with("plunge")) && !step.starts_with("retract");
    EXPECT_FALSE(is_down && step.starts_with("compensation")) << step;
  }
}

TEST(Compensation, TellsTheValueOfTheCompensationIndex) {
  const std::string header = "M48\nMETRIC,LZ\nCP,1,1.2\nCP,2,1.3\nT1C1.0\n%\n";
  const std::string contour = "\nG00X0.Y0.\nG41\nM15\nG01X10.Y0.\nM17\nM30\n";
  // Without an index it is the tool's number (Tool Selection with Compensation Index).
  EXPECT_THAT(steps(run_clean(header + "T1" + contour)), Contains("compensation left 1.2000"));
  EXPECT_THAT(steps(run_clean(header + "T0102" + contour)), Contains("compensation left 1.3000"));
}

TEST(Compensation, SidesAndArcsTurnOverInMirroredCopies) {
  struct Case {
    std::string mirror, kind, side;
  };
  for (const Case& one : std::vector<Case>{{"", "ccw", "left"},
                                           {"M80", "cw", "right"},
                                           {"M90", "cw", "right"},
                                           {"M70", "cw", "right"},
                                           {"M80M90", "ccw", "left"},
                                           {"M80M70", "ccw", "left"},
                                           {"M80M90M70", "cw", "right"}}) {
    const ProgramRun run = run_clean(metric_t1(
        "M25\nG00X10.Y0.\nG41\nM15\nG03X20.Y10.A10.\nM17\nM01\nM02X100." + one.mirror + "\nM08\n"));
    EXPECT_EQ(sides_at_plunges(run), (Lines{"left", one.side})) << one.mirror;
    EXPECT_THAT(steps(run),
                Contains(AllOf(StartsWith("rout 1 " + one.kind + " "), HasSubstr(" [1]"))))
        << one.mirror;
  }
}

TEST(Compensation, AMirroredArcLiesWhereTheMirrorPutsIt) {
  EXPECT_THAT(steps(run_clean(metric_t1("M25\nG00X10.Y0.\nM15\nG03X20.Y10.A10.\nM17\nM01\n"
                                        "M02X100.M80\nM08\n"))),
              AllOf(Contains("rout 1 ccw (20, 10) about (10, 10) [0]"),
                    Contains("position (90, 0) [1]"),
                    Contains("rout 1 cw (80, 10) about (90, 10) [1]")));
}

// --- CNC-7 manual: F#, table feed rate -----------------------------------------------------------

std::vector<double> feeds_inch_per_min(const ProgramRun& run) {
  std::vector<double> feeds;
  for (const Rout& rout : run.executed.routs()) feeds.push_back(rout.feed / inch_per_min(1));
  return feeds;
}

TEST(TableFeed, ManualExamplesStandInABlockOfTheirOwn) {
  const auto feeds = feeds_inch_per_min(run_clean(
      inch_t1("G00XY\nM15\nG01X01Y01\nF07\nX02Y01\nX03Y01\nF03\nX04Y01\nG02X05Y02A01\nM17\n")));
  ASSERT_EQ(feeds.size(), 5U);
  EXPECT_NEAR(feeds[0], 100, 1e-9);  // the default
  EXPECT_NEAR(feeds[1], 70, 1e-9);
  EXPECT_NEAR(feeds[2], 70, 1e-9);
  EXPECT_NEAR(feeds[3], 30, 1e-9);
  EXPECT_NEAR(feeds[4], 30, 1e-9);
}

TEST(TableFeed, MayStandInTheBlockOfAMove) {
  const auto feeds = feeds_inch_per_min(
      run_clean(inch_t1("G00X01Y01F05\nM15\nG01X02Y01\nG01X03Y01F04\nX04Y01\nM17\n")));
  ASSERT_EQ(feeds.size(), 3U);
  EXPECT_NEAR(feeds[0], 50, 1e-9);
  EXPECT_NEAR(feeds[1], 40, 1e-9);
  EXPECT_NEAR(feeds[2], 40, 1e-9);
}

TEST(TableFeed, MetricProgramsGiveMillimetresPerSecond) {
  const ProgramRun run = run_clean(metric_t1("G00X0.Y0.\nM15\nG01X9.Y0.\nF03\nX19.Y0.\nM17\n"));
  ASSERT_EQ(run.executed.routs().size(), 2U);
  EXPECT_NEAR(run.executed.routs()[0].feed.in_mm_s(), 42.3, 0.05);  // as the manual rounds it
  EXPECT_NEAR(run.executed.routs()[1].feed.in_mm_s(), 30, 1e-9);
}

TEST(TableFeed, OutsideTheManualsRangeIsWarnedOf) {
  for (const char* feed : {"F2", "F151", "F009"}) {
    EXPECT_THAT(run_clean(inch_t1("G00XY\n" + std::string(feed) + "\n")).diagnostics,
                Contains(says(8, "warning[rate-out-of-range]")))
        << feed;
    EXPECT_THAT(run_clean(inch_t1("G00XY" + std::string(feed) + "\n")).diagnostics,
                Contains(says(7, "warning[rate-out-of-range]")))
        << feed;
  }
  for (const char* feed : {"F010", "F150", "F15", "F02"}) {
    EXPECT_THAT(run_clean(inch_t1("G00XY\n" + std::string(feed) + "\n")).diagnostics,
                Each(Not(HasSubstr("rate-out-of-range"))))
        << feed;
  }
  for (const char* feed : {"F003", "F064"}) {
    EXPECT_THAT(run_clean(metric_t1("G00X0.Y0.\n" + std::string(feed) + "\n")).diagnostics,
                Contains(says(8, "warning[rate-out-of-range]")))
        << feed;
  }
  for (const char* feed : {"F004", "F063"}) {
    EXPECT_THAT(run_clean(metric_t1("G00X0.Y0.\n" + std::string(feed) + "\n")).diagnostics,
                Each(Not(HasSubstr("rate-out-of-range"))))
        << feed;
  }
}

// --- CNC-7 manual: Routed Circle Canned Cycle ----------------------------------------------------

/// For a tool of 0.1 inch; body lines count from 5 and the lines of `header`.
std::string circle_program(const std::string& header, const std::string& body) {
  return "M48\nINCH,LZ\nT1C.1\n" + header + "%\n" + body + "M30\n";
}

/// The first word of each step, without compensation that is only switched off.
Lines kinds(const ProgramRun& run) {
  Lines out;
  for (const std::string& step : steps(run)) {
    if (step != "compensation off") out.push_back(step.substr(0, step.find(' ')));
  }
  return out;
}

void expect_manual_circle(const ProgramRun& run, RoutKind kind) {
  // Half the tool inside the radius of 0.5 lies 0.45; plunged 0.01 off that, it routs 540 degrees
  // and ends 0.1 off the opposite edge.
  EXPECT_THAT(
      kinds(run),
      ElementsAre("tool", "position", "plunge", "rout", "rout", "rout", "rout", "retract", "end"));
  EXPECT_THAT(steps(run),
              AllOf(Contains("position (101.6, 90.424)"), Contains("plunge"), Contains("retract")));
  const std::vector<Rout>& routs = run.executed.routs();
  ASSERT_EQ(routs.size(), 4U);
  EXPECT_THAT(end_inch(routs[0]), IsNearMatrix(Vector2d(4, 4.45), kRounding_inch));
  EXPECT_THAT(end_inch(routs[1]), IsNearMatrix(Vector2d(4, 3.55), kRounding_inch));
  EXPECT_THAT(end_inch(routs[2]), IsNearMatrix(Vector2d(4, 4.45), kRounding_inch));
  EXPECT_THAT(end_inch(routs[3]), IsNearMatrix(Vector2d(4, 4.35), kRounding_inch));
  expect_arc(routs[0], kind, {4, 3.56}, 0.45);
  expect_arc(routs[1], kind, {4, 4.45}, 0.45);
  expect_arc(routs[2], kind, {4, 3.55}, 0.45);
  EXPECT_THAT(center_inch(routs[1]), IsNearMatrix(Vector2d(4, 4), kRounding_inch));
  EXPECT_THAT(center_inch(routs[2]), IsNearMatrix(Vector2d(4, 4), kRounding_inch));
  for (const Rout& rout : routs) EXPECT_NEAR(rout.feed / inch_per_min(1), 20, 1e-9);
}

TEST(RoutedCircle, ManualExample) {
  expect_manual_circle(run_clean(circle_program("", "T1\nG00\nF02\nG32X04Y04A005\n")),
                       RoutKind::Clockwise);
}

TEST(RoutedCircle, G33RoutsTheSamePlacesCounterclockwise) {
  expect_manual_circle(run_clean(circle_program("", "T1\nG00\nF02\nG33X04Y04A005\n")),
                       RoutKind::Counterclockwise);
}

TEST(RoutedCircle, TheRadiusMayBeThatOfAnEarlierMove) {
  const ProgramRun run = run_clean(circle_program("", "T1\nG00\nG32X02Y04A005\nG32X06Y04\n"));
  ASSERT_EQ(run.executed.routs().size(), 8U);
  EXPECT_THAT(end_inch(run.executed.routs()[4]), IsNearMatrix(Vector2d(6, 4.45), kRounding_inch));
  EXPECT_THAT(end_inch(run.executed.routs()[7]), IsNearMatrix(Vector2d(6, 4.35), kRounding_inch));
}

TEST(RoutedCircle, TheCompensationTableRulesOverTheDiameter) {
  const std::string table = "CP,1,.12\nCP,2,.14\n";
  const ProgramRun own = run_clean(circle_program(table, "T1\nG32X04Y04A005\n"));
  ASSERT_EQ(own.executed.routs().size(), 4U);
  EXPECT_THAT(end_inch(own.executed.routs()[0]), IsNearMatrix(Vector2d(4, 4.44), kRounding_inch));
  EXPECT_THAT(end_inch(own.executed.routs()[1]), IsNearMatrix(Vector2d(4, 3.56), kRounding_inch));
  const ProgramRun second = run_clean(circle_program(table, "T0102\nG32X04Y04A005\n"));
  ASSERT_EQ(second.executed.routs().size(), 4U);
  EXPECT_THAT(end_inch(second.executed.routs()[0]),
              IsNearMatrix(Vector2d(4, 4.43), kRounding_inch));
}

TEST(RoutedCircle, NeedsTheDiameter) {
  EXPECT_THAT(run_program("M48\nINCH,LZ\nT1F2\n%\nT1\nG32X04Y04A005\nM30\n").diagnostics,
              Contains(says(6, "error[diameter-missing]")));
}

TEST(RoutedCircle, TheRadiusIsAtLeastHalfTheCompensationAndAHundredth) {
  // 0.1 / 2 + 0.01
  EXPECT_FALSE(run_program(circle_program("", "T1\nG32X04Y04A.06\n")).has_errors);
  EXPECT_THAT(run_program(circle_program("", "T1\nG32X04Y04A.0599\n")).diagnostics,
              Contains(says(6, "error[")));
  EXPECT_THAT(run_program(circle_program("CP,1,.2\n", "T1\nG32X04Y04A.1\n")).diagnostics,
              Contains(says(7, "error[")));
}

TEST(RoutedCircle, LeavesTheRouterUp) {
  EXPECT_THAT(run_program(circle_program("", "T1\nG00\nG32X04Y04A005\nG01X05Y05\n")).diagnostics,
              Contains(says(8, "error[rout-not-plunged]")));
}

// --- CNC-7 manual: Routed Step Slot Canned Cycle -------------------------------------------------

constexpr char kStepSlotHeader[] = "M48\nINCH,LZ\nT6C.1\n%\n";

/// The steps of the router itself; with the router down there is no position to go to.
Lines router_steps(const ProgramRun& run) {
  Lines out;
  for (const std::string& step : steps(run)) {
    if (step.starts_with("plunge") || step.starts_with("rout") || step.starts_with("retract")) {
      out.push_back(step);
    }
  }
  return out;
}

TEST(StepSlot, ManualExample) {
  // 0.15 and 0.05 inch above the backup, then 0.05 into it; to and fro, never raised between.
  const ProgramRun run =
      run_clean(kStepSlotHeader + std::string("T6Z-.05\nX05Y06G87X05Y07Z-.1U.2\nM30\n"));
  EXPECT_EQ(router_steps(run),
            (Lines{"plunge 3.8100",
                   "rout 6 line (127, 177.8)",
                   "plunge 1.2700",
                   "rout 6 line (127, 152.4)",
                   "plunge -1.2700",
                   "rout 6 line (127, 177.8)",
                   "retract"}));
  EXPECT_THAT(steps(run), Contains("position (127, 152.4)"));
  EXPECT_TRUE(run.holes().empty());
  for (const Rout& rout : run.executed.routs()) {
    EXPECT_NEAR(rout.feed / inch_per_min(1), 100, 1e-9);
  }
}

TEST(StepSlot, TheLastPassMayBeReduced) {
  const ProgramRun run =
      run_clean(kStepSlotHeader + std::string("T6Z-.05\nX05Y06G87X05Y07Z-.1U.25\nM30\n"));
  Lines plunges;
  for (const std::string& step : router_steps(run)) {
    if (step.starts_with("plunge")) plunges.push_back(step);
  }
  // 0.2, 0.1, 0 and -0.05 inch.
  EXPECT_EQ(plunges, (Lines{"plunge 5.0800", "plunge 2.5400", "plunge 0.0000", "plunge -1.2700"}));
}

TEST(StepSlot, TheIncrementMustBeNegative) {
  EXPECT_THAT(
      run_program(kStepSlotHeader + std::string("T6\nX05Y06G87X05Y07Z.1U.2\nM30\n")).diagnostics,
      Contains(says(6, "error[")));
}

TEST(StepSlot, KeptIsOneOperation) {
  WalkOptions options;
  options.slots = options.step_slots = Cycles::Kept;
  EXPECT_THAT(
      run_clean(kStepSlotHeader + std::string("T6Z-.05\nX05Y06G87X05Y07Z-.1U.2\nM30\n"), options)
          .executed.lines(),
      AllOf(Contains("6 step_slot 6 (127, 152.4) (127, 177.8) 5.0800 -2.5400"),
            Not(Contains(HasSubstr(" rout "))),
            Not(Contains(HasSubstr(" plunge")))));
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
