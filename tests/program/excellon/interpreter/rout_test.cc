// SPDX-License-Identifier: Apache-2.0
// Routing: CNC-7 manual, Rout Mode to Retract without Clamping.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/excellon/interpreter/rout_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::inch_t1;
using test::metric;
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
using testing::StartsWith;

using Lines = std::vector<std::string>;

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
  struct MirroredSide {
    std::string mirror, kind, side;
  };
  for (const MirroredSide& one : std::vector<MirroredSide>{{"", "ccw", "left"},
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

}  // namespace
}  // namespace panelcal
