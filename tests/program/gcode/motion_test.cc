// SPDX-License-Identifier: Apache-2.0
#include "program/gcode/motion.h"

#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::gcode {
namespace {

using std::numbers::pi;
using test::Reports;
using testing::AllOf;
using ::testing::HasSubstr;

/// The moves of a program, or why there are none.
Expected<std::vector<Motion>> moves(const std::vector<std::string>& lines) {
  MotionReader reader("p.ngc");
  std::vector<Motion> all;
  int number = 0;
  for (const std::string& line : lines) {
    PANELCAL_TRY(const GcodeBlock block, read_gcode_block({line, ++number, 1}, "p.ngc"));
    PANELCAL_TRY(const auto motion, reader.read(block));
    if (motion) all.push_back(*motion);
  }
  return all;
}

Motion last(const std::vector<std::string>& lines) {
  const auto all = moves(lines);
  EXPECT_TRUE(all) << all.error().text();
  return all && !all->empty() ? all->back() : Motion();
}

std::string refusal(const std::vector<std::string>& lines) {
  const auto all = moves(lines);
  return all ? "accepted" : all.error().text();
}

TEST(GcodeMotion, KeepsWhatALineLeavesOut) {
  const Motion move = last({"G21 G0 X1 Y2 Z3", "G1 Z-0.5 F100", "Y7"});
  EXPECT_EQ(move.kind, MotionKind::Line);
  EXPECT_EQ(move.from.xy_mm(), Eigen::Vector2d(1, 2));
  EXPECT_EQ(move.to.xy_mm(), Eigen::Vector2d(1, 7));
  EXPECT_EQ(move.to.z_mm, -0.5);
}

TEST(GcodeMotion, AddsStepsUp) {
  const std::vector<std::string> start = {"G21 G0 X1 Y2 Z2", "G91 G1 X0.5 Z-2.1"};
  EXPECT_EQ(last(start).to.xy_mm(), Eigen::Vector2d(1.5, 2));
  EXPECT_EQ(last(start).to.z_mm, -0.1);
  // Up again to the very height, though 2 - 2.1 + 2.1 is less in binary digits.
  EXPECT_EQ(last({start[0], start[1], "Z2.1"}).to.z_mm, 2);
  EXPECT_EQ(last({start[0], start[1], "G90 X4"}).to.xy_mm(), Eigen::Vector2d(4, 2));
  EXPECT_EQ(last({"G20 G0 X1 Y1", "G91 X1"}).to.xy_mm(), Eigen::Vector2d(50.8, 25.4));
  const Motion arc = last({start[0], "G91 G3 X-10 Y10 I-10 J0"});
  EXPECT_EQ(arc.center_mm, Eigen::Vector2d(-9, 2));
  EXPECT_NEAR(arc.sweep_rad, pi / 2, 1e-12);
}

TEST(GcodeMotion, AStepFromNobodyKnowsWhereLeadsNowhere) {
  const Motion move = last({"G21 G0 X1", "G91 X1 Y1 Z5", "X1"});
  EXPECT_EQ(move.to.x_mm, 3);
  EXPECT_FALSE(move.to.y_mm);
  EXPECT_FALSE(move.to.z_mm);
  EXPECT_THAT(refusal({"G21 G0 X1 Y1 Z1", "G3 X2 Y2 R1", "G4 I-5"}),
              HasSubstr("error[not-supported]"));
  EXPECT_THAT(refusal({"G21 G91 G2 X1 I0.5"}), HasSubstr("error[coordinate-missing]"));
}

TEST(GcodeMotion, CountsInMillimetres) {
  EXPECT_EQ(last({"G20 G0 X1 Y-2"}).to.xy_mm(), Eigen::Vector2d(25.4, -50.8));
  EXPECT_FALSE(last({"G20 G0 X1 Y-2"}).to.z_mm);
}

TEST(GcodeMotion, FindsTheCentreOfArcs) {
  const std::vector<std::string> start = {"G21 G0 X10 Y0 Z0"};
  const auto arc = [&](const std::string& line) { return last({start[0], line}); };
  EXPECT_EQ(arc("G3 X0 Y10 I-10 J0").center_mm, Eigen::Vector2d(0, 0));
  EXPECT_NEAR(arc("G3 X0 Y10 I-10 J0").sweep_rad, pi / 2, 1e-12);
  EXPECT_NEAR(arc("G2 X0 Y10 I-10 J0").sweep_rad, -3 * pi / 2, 1e-12);
  EXPECT_NEAR(arc("G2 I-10").sweep_rad, -2 * pi, 1e-12);
  // By their radius: the short way, or with a negative one the long way.
  EXPECT_NEAR(arc("G3 X0 Y10 R10").center_mm.norm(), 0, 1e-12);
  EXPECT_NEAR(arc("G2 X0 Y10 R-10").center_mm.norm(), 0, 1e-12);
  EXPECT_NEAR((arc("G2 X0 Y10 R10").center_mm - Eigen::Vector2d(10, 10)).norm(), 0, 1e-12);
  EXPECT_NEAR(arc("G2 X0 Y10 R10").sweep_rad, -pi / 2, 1e-12);
  EXPECT_NEAR(arc("G3 X0 Y10 R-10").sweep_rad, 3 * pi / 2, 1e-12);
  EXPECT_EQ(last({start[0], "G90.1", "G3 X0 Y10 I0 J0"}).center_mm, Eigen::Vector2d(0, 0));
}

TEST(GcodeMotion, KeepsZAndROfCycles) {
  const Motion hole = last({"G21 G0 X0 Y0 Z5", "G81 X1 Y1 Z-2 R0.5 F50", "X2"});
  EXPECT_EQ(hole.kind, MotionKind::Cycle);
  EXPECT_EQ(hole.to.xy_mm(), Eigen::Vector2d(2, 1));
  EXPECT_EQ(hole.to.z_mm, -2);
  EXPECT_EQ(hole.retract_mm, 0.5);
  EXPECT_EQ(hole.from.z_mm, 5);  // G98: back to where it was
  EXPECT_EQ(last({"G21 G0 X0 Y0 Z5", "G99 G81 X1 Y1 Z-2 R0.5", "X2"}).from.z_mm, 0.5);
  EXPECT_THAT(refusal({"G21 G0 X0 Y0 Z5", "G81 X1 Z-2 R0.5", "G80", "G81 X2"}),
              HasSubstr("p.ngc:4:1: error[coordinate-missing]"));
}

TEST(GcodeMotion, DoesNotKnowWhereItIsBehindMovesOfTheMachine) {
  const Motion move = last({"G21 G0 X1 Y2 Z3", "G28", "G0 X5"});
  EXPECT_FALSE(move.from.x_mm);
  EXPECT_FALSE(move.to.y_mm);
  EXPECT_EQ(move.to.x_mm, 5);
  EXPECT_FALSE(last({"G21 G0 X1 Y2 Z3", "G53 G0 Z0", "G0 X5"}).to.z_mm);
  // The usual way home: the way there is incremental, the next move is not.
  EXPECT_EQ(refusal({"G21 G0 X1 Y2", "G91 G28 Z0", "G90 G0 X3"}), "accepted");
}

TEST(GcodeMotion, GoesBackToWhereASeriesOfCyclesBegan) {
  const std::vector<std::string> lines = {
      "G21 G0 X0 Y0 Z5", "G99 G81 X1 Y1 Z-2 R0.5", "X2", "G98 X3"};
  EXPECT_EQ(last({lines[0], lines[1]}).travel_mm, 0.5);
  EXPECT_EQ(last(lines).travel_mm, 5);
  EXPECT_THAT(refusal({lines[0], lines[1], "G82 X2"}), HasSubstr("error[coordinate-missing]"));
}

// Printed by rs274: with Z-2 R-4 from Z5 holes are drilled from 1 to -1, with G99 the next ones
// too.
TEST(GcodeMotion, CyclesInStepsKeepTheirHeights) {
  for (const std::string mode : {"G98", "G99"}) {
    const std::vector<std::string> lines = {
        "G21 G0 X0 Y0 Z5", "G91 G81 X1 Y1 Z-2 R-4 " + mode, "X1"};
    EXPECT_EQ(last(lines).to.xy_mm(), Eigen::Vector2d(2, 1));
    EXPECT_EQ(last(lines).to.z_mm, -1);
    EXPECT_EQ(last(lines).retract_mm, 1);
    EXPECT_EQ(last(lines).travel_mm, mode == "G98" ? 5 : 1);
  }
  EXPECT_THAT(refusal({"G21 G0 X0 Y0", "G91 G81 X1 Y1 Z-2 R-4"}),
              HasSubstr("p.ngc:2:1: error[coordinate-missing]"));
}

TEST(GcodeMotion, KnowsTheAxesThatAMoveOfTheMachineLeaves) {
  const Motion move = last({"G21 G0 X1 Y2 Z3", "G53 G0 Z0", "G0 X5"});
  EXPECT_EQ(move.from.xy_mm(), Eigen::Vector2d(1, 2));
  EXPECT_FALSE(last({"G21 G0 X1 Y2 Z3", "G53 G0 Y0", "G0 X5"}).to.y_mm);
}

TEST(GcodeMotion, ForgetsWhereItIsBehindAChangeOfTool) {
  EXPECT_FALSE(last({"G21 G0 X1 Y2 Z3", "T2 M6", "G0 Z5"}).to.has_xy());
  EXPECT_FALSE(last({"G21 G0 X1 Y2 Z3", "G43 H1", "G0 X5"}).to.z_mm);
}

TEST(GcodeMotion, RefusesWhateverStandsBehindTheEnd) {
  EXPECT_EQ(refusal({"G21 G0 X1 Y2 Z3 M2", "%", "(bye)", ""}), "accepted");
  EXPECT_THAT(refusal({"G21 G0 X1 Y2 Z3", "M30", "G1 Z-1"}),
              HasSubstr("p.ngc:3:1: error[not-supported]"));
}

TEST(GcodeMotion, RefusesWhatTheOperatorMayLeaveOut) {
  for (const std::string line : {"/X1", "/M2", "/G20", "/G91", "/F10"}) {
    EXPECT_THAT(refusal({"G21 G0 X1 Y2 Z3", line}),
                AllOf(HasSubstr("p.ngc:2:"), HasSubstr("error[not-supported]")))
        << line;
  }
  EXPECT_EQ(refusal({"G21 G0 X1 Y2 Z3", "/(a comment)", "/N5"}), "accepted");
}

TEST(GcodeMotion, RefusesWhatItCannotFollow) {
  const auto after_start = [](const std::string& line) {
    return refusal({"G21 G0 X10 Y0 Z0", line});
  };
  for (const std::string line : {"G18",
                                 "X#1",
                                 "G1 Z[1+2]",
                                 "M[3]",
                                 "G2 X0 Y10 I-10 P#1",
                                 "G41 D1",
                                 "G92 X0",
                                 "G10 L2 P1 X0",
                                 "G38.2 Z-1",
                                 "G52 X1",
                                 "G55",
                                 "X1 A90",
                                 "M98 P5",
                                 "M70",
                                 "M71",
                                 "M72",
                                 "M73",
                                 "M100",
                                 "M199 P1",
                                 "G93 G1 X1",
                                 "/X1",
                                 "G2 X0 Y10 I-10 P2",
                                 "G81 X1 Z-1 R1 L3",
                                 "G33 Z-1 K1",
                                 "G43.1 Z1"}) {
    EXPECT_THAT(after_start(line), HasSubstr("error[not-supported]")) << line;
  }
  EXPECT_THAT(refusal({"G0 X1"}), Reports("p.ngc:1:1: error[argument-invalid]"));
  EXPECT_THAT(refusal({"G21", "X1"}), HasSubstr("p.ngc:2:1: error[not-supported]"));
  EXPECT_EQ(refusal({"G21", "G55", "G0 X1", "G55", "G40 G49 G50 G69 G80"}), "accepted");
  EXPECT_EQ(refusal({"G21 G0 X1", "M3 S100", "M8", "M66 P1", "M9", "M5"}), "accepted");
}

TEST(GcodeMotion, RefusesArcsThatAreNone) {
  const auto arc = [](const std::string& line) { return refusal({"G21 G0 X10 Y0 Z0", line}); };
  EXPECT_THAT(arc("G3 X0 Y10"), HasSubstr("p.ngc:2:1: error[argument-invalid]"));
  EXPECT_THAT(arc("G3 X0 Y11 I-10 J0"),
              Reports("p.ngc:2:1: error[argument-invalid]", "10.0000 mm", "11.0000 mm"));
  EXPECT_THAT(arc("G3 X40 Y0 R10"),
              AllOf(HasSubstr("p.ngc:2:"), HasSubstr("error[argument-invalid]")));
  EXPECT_THAT(arc("G3 X10 Y0 R10"), HasSubstr("error[argument-invalid]"));
  EXPECT_THAT(arc("G3 X0 Y10 I0 J0"), HasSubstr("error[argument-invalid]"));
  EXPECT_THAT(refusal({"G21", "G3 X0 Y10 I-10 J0"}), HasSubstr("error[coordinate-missing]"));
}

}  // namespace
}  // namespace panelcal::gcode
