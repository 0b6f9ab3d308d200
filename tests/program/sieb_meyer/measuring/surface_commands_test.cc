// SPDX-License-Identifier: Apache-2.0
// Surface commands that the manual names without an example: G72, G76, G77, BOTR and BOTT.
#include <string>
#include <utility>
#include <vector>

#include "program/walk/probing.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/heights.h"
#include "tests/program/sieb_meyer/manual_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::expect_refused;
using test::format_5000;
using test::Heights;
using test::ProgramRun;
using test::run_program;
using test::steps_of;
using testing::ElementsAre;

ProgramRun run_with(const std::string& body, std::vector<double> heights_mm) {
  DiagnosticLog log;
  ProgramRun run;
  run.program = load_program({"p.exc", format_5000(body)}, log);
  NominalSource targets;
  Heights probes(std::move(heights_mm));
  run.survey = survey(run.program, {}, targets, probes, log);
  run.has_errors = log.has_errors();
  if (!run.has_errors) execute(run.program, {}, run.survey, run.executed, log);
  run.diagnostics = test::briefs(log);
  for (const Diagnostic& diagnostic : log.kept()) run.texts.push_back(diagnostic.text());
  return run;
}

/// A 2 x 2 grid about (5, 5), 0.2 mm higher on its right side than at the reference.
const std::string kGrid = "XYG78\nXYG79\nX10.YG79\nXY10.G79\nX10.Y10.G79\n";
const std::vector<double> kGridHeights = {1.6, 1.6, 1.8, 1.6, 1.8};

/// "Measure depth/residual web and record deviation": it changes no reference.
TEST(SurfaceCommands, G76OnlyRecords) {
  const ProgramRun run = run_with("G71K.4\nX1.Y1.G73L1\nX2.Y2.G76\nX3.Y3.T1\nG70\n", {1.6, 1.9});
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  ASSERT_EQ(run.survey.probes.size(), 2U);
  EXPECT_EQ(run.survey.probes[1].request.command, "G76");
  EXPECT_EQ(run.survey.probes[1].heights[0].height, mm(1.9));
  EXPECT_THAT(steps_of(run), ElementsAre("tool 1", "drill 1 (3, 3) depth 0.4 surface 1.6"));
}

/// "Deactivate surface detection for one block."
TEST(SurfaceCommands, G77TakesNoAccountOfTheSurfaceInItsLine) {
  const ProgramRun slm = run_with("G71K.4\nX1.Y1.G73L1\nX2.Y2.T1Z.5G77\nX3.Y3.\nG70\n", {1.6});
  ASSERT_FALSE(slm.has_errors) << testing::PrintToString(slm.diagnostics);
  EXPECT_THAT(
      steps_of(slm),
      ElementsAre("tool 1", "drill 1 (2, 2) z 0.5", "drill 1 (3, 3) depth 0.4 surface 1.6"));
  const ProgramRun grid = run_with(kGrid + "X10.Y5.T1Z.5\nX10.Y6.G77\nX10.Y7.\n", kGridHeights);
  ASSERT_FALSE(grid.has_errors) << testing::PrintToString(grid.diagnostics);
  EXPECT_THAT(steps_of(grid),
              ElementsAre("tool 1",
                          "drill 1 (10, 5) z 0.7 surface 1.8",
                          "drill 1 (10, 6) z 0.5",
                          "drill 1 (10, 7) z 0.7 surface 1.8"));
}

/// G72 forgets the stored values, not the reference in force.
TEST(SurfaceCommands, G72ForgetsWhatWasStored) {
  const ProgramRun run =
      run_with("G71K.4\nX1.Y1.G73L1\nX2.Y2.G73L2\nG72\nX3.Y3.T1\nX4.Y4.G73L1\nL1\nX5.Y5.\nG70\n",
               {1.6, 1.7, 1.8});
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 1",
                          "drill 1 (3, 3) depth 0.4 surface 1.7",
                          "drill 1 (5, 5) depth 0.4 surface 1.8"));
  expect_refused(run_with("G71K.4\nX1.Y1.G73L1\nX2.Y2.G73L2\nG72\nL2\nX3.Y3.T1\nG70\n", {1.6, 1.7}),
                 6,
                 {"L2"});
}

/// Without G78 the grid's heights count from BOTR; then BOTT holds them against it.
TEST(SurfaceCommands, BotrIsTheReferenceOfTheGrid) {
  const std::string grid = "XYG79\nX10.YG79\nXY10.G79\nX10.Y10.G79\nX5.Y5.T1Z.5\n";
  const ProgramRun run = run_with("M49,BOTR1.5\n" + grid, {1.6, 1.6, 1.6, 1.6});
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(steps_of(run),
              ElementsAre("setting M49,BOTR1.5", "tool 1", "drill 1 (5, 5) z 0.6 surface 1.6"));
  EXPECT_EQ(run.survey.probes[0].request.reference, mm(1.5));
  const ProgramRun refused = run_with("M49,BOTR1.5\nM49,BOTT0.05\n" + grid, {1.54, 1.56, 1.6, 1.6});
  expect_refused(refused, 5, {"BOTT"});
}

/// The depth of a contour's piece is that of its own line, not that of the next one.
TEST(SurfaceCommands, G77AndG83HoldForTheirOwnLinesOfAContour) {
  const ProgramRun grid =
      run_with(kGrid + "X10.Y1.T1T0Z1.\nX10.Y3.G1\nX10.Y5.G77\nX10.Y7.\nX10.Y7.T0\n", kGridHeights);
  ASSERT_FALSE(grid.has_errors) << testing::PrintToString(grid.diagnostics);
  EXPECT_THAT(steps_of(grid),
              ElementsAre("tool 1",
                          "position (10, 1)",
                          "plunge z 1.2 surface 1.8",
                          "rout 1 line (10, 3) z 1.2 surface 1.8",
                          "plunge z 1",
                          "rout 1 line (10, 5) z 1",
                          "plunge z 1.2 surface 1.8",
                          "rout 1 line (10, 7) z 1.2 surface 1.8",
                          "retract"));
  const ProgramRun depth = run_with(
      kGrid + "X10.Y1.T1T0Z1.\nX10.Y3.G1\nX10.Y5.G83K.4\nX10.Y7.G82\nX10.Y7.T0\n", kGridHeights);
  ASSERT_FALSE(depth.has_errors) << testing::PrintToString(depth.diagnostics);
  EXPECT_THAT(steps_of(depth),
              ElementsAre("tool 1",
                          "position (10, 1)",
                          "plunge z 1.2 surface 1.8",
                          "rout 1 line (10, 3) z 1.2 surface 1.8",
                          "plunge depth 0.4",
                          "rout 1 line (10, 5) depth 0.4",
                          "plunge z 1.2 surface 1.8",
                          "rout 1 line (10, 7) z 1.2 surface 1.8",
                          "retract"));
}

/// An arc from corner to corner reaches 20 mm beyond the grid between them.
TEST(SurfaceCommands, ArcsMayNotLeaveTheGridBetweenTheirEnds) {
  const std::string grid = "XYG79\nX40.YG79\nXY40.G79\nX40.Y40.G79\nX40.YT1T0Z1.\n";
  const std::vector<double> flat(4, 1.6);
  expect_refused(run_with(grid + "X40.Y40.G3R20.\nX40.Y40.T0\n", flat), 7, {"outside the grid"});
  EXPECT_FALSE(run_with(grid + "X40.Y40.G2R20.\nX40.Y40.T0\n", flat).has_errors);
}

/// "Otherwise the error STEP+REPEAT error + Usage of manual measurements not finished occurs": also
/// where surface detection is on outside of the section.
TEST(SurfaceCommands, SectionsLeaveSurfaceDetectionAsTheyFoundIt) {
  const std::string outside = "G71K.4\nX1.Y1.G73L1\n";
  const std::string copies = "XYM50\nX100.YM50M30\n";
  const std::vector<double> heights = {1.5, 1.5, 1.5};
  EXPECT_FALSE(run_with(outside + "M31\nX2.Y2.T1\n" + copies + "G70\n", heights).has_errors);
  expect_refused(run_with(outside + "M31\nX2.Y2.T1\nG70\n" + copies, heights), 7, {"G70"});
  expect_refused(run_with(outside + "M31\nG71\nX2.Y2.T1\n" + copies, heights), 7, {"G71"});
}

/// "Only the surface value ahead the T0 block is considered for a complete routing contour."
TEST(SurfaceCommands, AReferenceBehindT0IsRefused) {
  expect_refused(
      run_with("G71K.4\nX1.Y1.G73L1\nX9.Y9.G73L2\nX10.Y10.T1T0\nL2\nX20.Y10.G1\nX20.Y10.T0\nG70\n",
               {1.5, 1.7}),
      7,
      {"L# before the T0 line"});
}

/// K: "Only positive values are allowed"; G71 allows residual webs.
TEST(SurfaceCommands, AResidualWebEndsWithG70) {
  expect_refused(
      run_with("G83K.4\nX1.Y1.G73L1\nG71K-2.\nX2.Y2.T1\nG70\nX3.Y3.\n", {3.5}), 6, {"K-2"});
}

/// Z: "For the depth control (relative working plane) the Z-value is the minimum limit for lowering
/// the Z-axis."
TEST(SurfaceCommands, StrokesBelowZAreRefused) {
  const std::string hole = "G71K.4\nX1.Y1.G73L1\nX2.Y2.T1\nG70\n";
  expect_refused(run_with("Z3.\n" + hole, {1.5}), 5, {"1.500", "Z3.000"});
  EXPECT_FALSE(run_with("Z1.\n" + hole, {1.5}).has_errors);
}

/// I counts from the board's surface there, as under G83.
TEST(SurfaceCommands, PeckStrokesUnderG71GoToTheDepth) {
  const ProgramRun run = run_with("G81I2.J.5W100\nX1.Y1.G73L1\nG71K3.\nX2.Y2.T1\nG70\n", {3.5});
  EXPECT_THAT(run.texts, testing::Contains(testing::HasSubstr("4.445 mm")));
}

/// "Clear all values in the surface memory", where the grid's are as well.
TEST(SurfaceCommands, G72ForgetsTheGrid) {
  const ProgramRun run = run_with(kGrid + "G72\nX10.Y5.T1Z.5\n", kGridHeights);
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(steps_of(run), ElementsAre("tool 1", "drill 1 (10, 5) z 0.5"));
}

/// "Save the current measured value": also one of the grid.
TEST(SurfaceCommands, G73WithoutAPlaceSavesWhatTheGridProbedLast) {
  const ProgramRun run = run_with(kGrid + "G71K.4\nG73L1\nL1\nX1.Y1.T1\nG70\n", kGridHeights);
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(steps_of(run), ElementsAre("tool 1", "drill 1 (1, 1) depth 0.4 surface 1.8"));
}

TEST(SurfaceCommands, OnlyG73AndG74StoreUnderL) {
  for (const char* order :
       {"G72L1\n", "G75L1\n", "X1.Y1.G76L1\n", "X1.Y1.G78L1\n", "X1.Y1.G79L1\n"}) {
    expect_refused(run_with(order, {1.5}), 2, {"L#"});
  }
}

/// G78 "works like G79": it is held against the reference too; and each tolerance holds by itself.
TEST(SurfaceCommands, EveryToleranceHolds) {
  expect_refused(run_with("M49,BOTR1.5\nM49,BOTT,R0.1\nX1.Y1.G78\n", {3.0}), 4, {"BOTT"});
  expect_refused(
      run_with("M49, MAPT0.1\nM49,TOPT,R1.0\nXYG79\nX10.YG79\n", {1.5, 1.9}), 5, {"MAPT"});
  expect_refused(run_with("M49,BOTR1.5\nM49,TOPR1.6\nXYG79\n", {1.5}), 3, {"one reference"});
}

/// "If BOTK/TOPK is defined, a depth hole stroke is always carried out"; a tool in the line "has
/// priority over the setting with the CNC command BOTL/TOPL".
TEST(SurfaceCommands, BotkAndBotlSayHowIsProbed) {
  const ProgramRun run = run_with(
      "M49,BOTK.5\nM49,BOTL7\nXYG79\nX10.YT3G79\nXY10.G79\nX10.Y10.G79\n", {1.5, 1.5, 1.5, 1.5});
  ASSERT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  ASSERT_EQ(run.survey.probes.size(), 4U);
  EXPECT_EQ(run.survey.probes[0].request.depth, mm(0.5));
  EXPECT_EQ(run.survey.probes[0].request.tool, 7);
  EXPECT_EQ(run.survey.probes[1].request.tool, 3);
}

/// "If TD is located in the line of the program command, the dummy tool is picked up."
TEST(SurfaceCommands, TheDummyToolTakesThePlaceOfTheTool) {
  const ProgramRun run = run_with("X1.Y1.T1\nX2.Y2.TDG79\n", {1.5});
  ASSERT_EQ(run.survey.probes.size(), 1U);
  EXPECT_EQ(run.survey.probes[0].request.tool, 0);
  expect_refused(run_with("X1.Y1.T1\nX2.Y2.TDG73L1\nX3.Y3.\n", {1.5}), 4, {"tool"});
}

/// SPAV in the program: 1.4, 1.5 and 1.9 have the mean 1.6, the median 1.5, the mid-range 1.65 and
/// without least and greatest 1.5.
TEST(SurfaceCommands, SpavChoosesTheAverage) {
  const auto surface = [](const std::string& letter) {
    const ProgramRun run = run_with("M49,SPAV," + letter +
                                        "\nG71K.4\nX1.Y1.G73\nX2.Y1.G73\nX3.Y1.G73\nG74L1\nL1\n"
                                        "X5.Y5.T1\nG70\n",
                                    {1.4, 1.5, 1.9});
    return steps_of(run).back();
  };
  EXPECT_EQ(surface("A"), "drill 1 (5, 5) depth 0.4 surface 1.6");
  EXPECT_EQ(surface("M"), "drill 1 (5, 5) depth 0.4 surface 1.5");
  EXPECT_EQ(surface("O"), "drill 1 (5, 5) depth 0.4 surface 1.65");
  EXPECT_EQ(surface("T"), "drill 1 (5, 5) depth 0.4 surface 1.5");
}

}  // namespace
}  // namespace panelcal
