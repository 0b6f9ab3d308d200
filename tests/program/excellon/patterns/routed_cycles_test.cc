// SPDX-License-Identifier: Apache-2.0
// CNC-7 manual, Routed Circle Canned Cycle and Routed Step Slot Canned Cycle.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/excellon/interpreter/rout_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::center_inch;
using test::end_inch;
using test::expect_arc;
using test::IsNearMatrix;
using test::kRounding_inch;
using test::ProgramRun;
using test::run_clean;
using test::run_program;
using test::says;
using test::steps;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

using Lines = std::vector<std::string>;

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

}  // namespace
}  // namespace panelcal
