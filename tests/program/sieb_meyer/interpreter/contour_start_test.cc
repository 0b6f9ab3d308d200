// SPDX-License-Identifier: Apache-2.0
// A contour is routed from where its T0 line says, wherever the machine was before.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"

namespace panelcal::test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

/// Executed steps, without the lines that it comes from. `body` follows %%5000; tools 1 to 9 have 2
/// mm.
std::vector<std::string> steps(const std::string& body) {
  std::string text = "%%5000\n" + body + "$\n";
  for (int tool = 1; tool <= 9; ++tool) text += "T" + std::to_string(tool) + "D2.\n";
  const ProgramRun run = run_program(text + "$\n");
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  std::vector<std::string> out;
  for (const std::string& line : run.executed.lines())
    out.push_back(line.substr(line.find(' ') + 1));
  return out;
}

/// The step before the last plunge.
std::string before_last_plunge(const std::string& body) {
  const std::vector<std::string> all = steps(body);
  for (std::size_t i = all.size(); i > 1; --i) {
    if (all[i - 1].starts_with("plunge")) return all[i - 2];
  }
  return "no plunge";
}

void expect_refused(const std::string& body, const std::string& slug) {
  const ProgramRun run = run_program("%%5000\n" + body + "$\nT5D2.\n$\n");
  EXPECT_TRUE(run.has_errors) << body;
  EXPECT_THAT(run.diagnostics, Contains(HasSubstr("[" + slug + "]"))) << body;
}

const std::string kContour = "X10.Y10.T5T0\nX20.Y10.G1\nX20.Y10.T0\n";

TEST(ContourStart, NeedsNoMoveWhereTheLastContourEnded) {
  EXPECT_EQ(before_last_plunge(kContour + "X20.Y10.T0\nX30.Y10.G1\nX30.Y10.T0\n"), "retract");
}

TEST(ContourStart, MovesBehindAFigure) {
  EXPECT_EQ(
      before_last_plunge("X50.Y50.T5T0\nX50.Y50.G46R20.\nX50.Y50.T0\nX90.Y50.G1\nX90.Y50.T0\n"),
      "position (50, 50)");
}

TEST(ContourStart, MovesBehindWhateverLeftTheTableElsewhere) {
  const std::string again = "X20.Y10.T0\nX30.Y10.G1\nX30.Y10.T0\n";
  for (const char* between : {"X0.Y0.V4\nX20.Y10.W4\n",
                              "X20.Y10.M97,A\n",
                              "X20.Y10.M28\n",
                              "M47,&PTURN\n",
                              "T6\n",
                              "M34\n",
                              "M20\n",
                              "M49,M101\n"}) {
    EXPECT_EQ(before_last_plunge(kContour + between + again), "position (20, 10)") << between;
  }
}

TEST(ContourStart, AnEmptyT0StandsForTheLastPlace) {
  EXPECT_EQ(before_last_plunge(kContour + "X0.Y0.V4\nX20.Y10.W4\nT0\nX30.Y10.G1\nX30.Y10.T0\n"),
            "position (20, 10)");
}

TEST(ContourStart, IsNotLeftOverFromASectionACallOrAnArea) {
  expect_refused(
      "X10.Y10.T5T0M31\nX20.Y10.G1\nX20.Y10.T0\nX0Y0M50\nX50.Y0M50M30\nX30.Y0G1\nX30.Y0T0\n",
      "contour-unopened");
  expect_refused("X10.Y10.T5T0\nX60.Y10.M58D3.\nX20.Y10.G1\nX20.Y10.T0\n", "contour-unopened");
  expect_refused("X10.Y10.T5T0\nX20.Y10.G1\n", "contour-unclosed");
}

TEST(ContourDepth, AnotherZWithoutG6IsAStepAndNoRamp) {
  EXPECT_THAT(steps("X0Y0T0T5Z3.\nX10.Y0G1\nX20.Y0Z2.\nX30.Y0G6Z1.\nX30.Y0T0\n"),
              ElementsAre("tool 5",
                          "position (0, 0)",
                          "plunge z 3",
                          "rout 5 line (10, 0) z 3",
                          "plunge z 2",
                          "rout 5 line (20, 0) z 2",
                          "rout 5 line (30, 0) z 1",
                          "retract"));
}

TEST(ContourDepth, ARampNeedsToKnowWhereItBegins) {
  expect_refused("X0Y0T0T5\nX10.Y0G1G6Z1.\nX10.Y0T0\n", "coordinate-missing");
}

/// Ten arcs of a scaled half circle go down evenly.
TEST(ContourDepth, PiecesOfAnArcShareItsRamp) {
  const std::vector<std::string> all =
      steps("M49,SAX90000.Y0\nX0Y0T0T5Z2.M93\nX10.Y0G1\nX30.Y0G2R10.G6Z1.\nX30.Y0T0\n");
  double last_z = 2;
  int n_pieces = 0;
  for (const std::string& step : all) {
    if (step.find(" cw ") == std::string::npos) continue;
    const double z = std::stod(step.substr(step.find(" z ") + 3));
    EXPECT_LT(z, last_z) << step;
    last_z = z;
    ++n_pieces;
  }
  EXPECT_GT(n_pieces, 4);
  EXPECT_DOUBLE_EQ(last_z, 1);
}

TEST(LineWords, ThatTheLineCannotUseAreRefused) {
  for (const char* line : {"X1.Y1.T5T0V2",
                           "X1.Y1.T5G84R5.T0",
                           "X1.Y1.T5T0G1",
                           "X1.Y1.T5D5.",
                           "X1.Y1.T5G11",
                           "X1.Y1.T5R2.",
                           "X1.Y1.T5G41"}) {
    expect_refused(std::string(line) + "\nX9.Y9.W3\n", "command-misplaced");
  }
}

TEST(LineWords, G40WithNothingToTurnOffIsNone) {
  EXPECT_THAT(steps("G40\nX1.Y1.T5\n"), ElementsAre("tool 5", "drill 5 (1, 1)"));
}

}  // namespace
}  // namespace panelcal::test
