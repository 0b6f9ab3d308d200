// SPDX-License-Identifier: Apache-2.0
// SIEB & MEYER manual, chapter 5 (Repeat, Offset and Mirror Patterns), 8.1 (Reference Points for
// Coordinates) and the examples of T and M97 that repeat sections.
#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::expect_places;
using test::hole_places;
using test::joined;
using test::Places;
using test::ProgramRun;
using test::rout_ends;
using test::run_5000;
using test::run_program;
using test::shifted;
using test::steps_of;
using testing::Contains;
using testing::ElementsAre;

using Lines = std::vector<std::string>;
using Paths = std::vector<InstancePath>;

Paths paths(const ProgramRun& run) {
  Paths out;
  for (const test::Hole& hole : run.holes()) out.push_back(hole.path);
  return out;
}

// --- chapter 5.5: the contour of every offset command --------------------------------------------

/// Places that the manual prints for the contour's four rout lines, and that of its start line
/// X10.Y30. by the manual's own calculation of the offset.
struct OffsetExample {
  std::string command;
  std::string first_zero;
  std::string second_zero;
  Places first;
  Places second;
  Vector2d first_start;
  Vector2d second_start;
};

void PrintTo(const OffsetExample& example, std::ostream* out) {
  *out << example.command;
}

std::string command_of(const testing::TestParamInfo<OffsetExample>& example) {
  return example.param.command;
}

class ManualOffsets : public testing::TestWithParam<OffsetExample> {};

TEST_P(ManualOffsets, ContourIsRoutedAtBothZeroPointsOnly) {
  const OffsetExample& example = GetParam();
  const ProgramRun run =
      run_5000("X10.Y30.T0T2 M31\nX10.Y40.G1 F1.2\nX20.Y40.\nX20.Y10.\nX10.Y10.\nX10.Y10.T0\n" +
               example.first_zero + example.command + "\n" + example.second_zero + example.command +
               " M30\n");
  expect_places(rout_ends(run), joined(example.first, example.second));
  std::vector<std::string> starts;
  for (const std::string& step : steps_of(run)) {
    if (step.starts_with("position")) starts.push_back(step);
  }
  const auto position = [](const Vector2d& p, const char* path) {
    return "position (" + std::to_string(static_cast<int>(p.x())) + ", " +
           std::to_string(static_cast<int>(p.y())) + ") " + path;
  };
  EXPECT_THAT(
      starts,
      ElementsAre(position(example.first_start, "[0]"), position(example.second_start, "[1]")));
}

INSTANTIATE_TEST_SUITE_P(Chapter55,
                         ManualOffsets,
                         testing::Values(OffsetExample{"M50",
                                                       "X30.Y40.",
                                                       "X70.Y20.",
                                                       {{40, 80}, {50, 80}, {50, 50}, {40, 50}},
                                                       {{80, 60}, {90, 60}, {90, 30}, {80, 30}},
                                                       {40, 70},
                                                       {80, 50}},
                                         OffsetExample{"M60",
                                                       "X60.Y60.",
                                                       "X90.Y10.",
                                                       {{20, 70}, {20, 80}, {50, 80}, {50, 70}},
                                                       {{50, 20}, {50, 30}, {80, 30}, {80, 20}},
                                                       {30, 70},
                                                       {60, 20}},
                                         OffsetExample{"M60M70",
                                                       "X10.Y60.",
                                                       "X30.Y10.",
                                                       {{50, 70}, {50, 80}, {20, 80}, {20, 70}},
                                                       {{70, 20}, {70, 30}, {40, 30}, {40, 20}},
                                                       {40, 70},
                                                       {60, 20}},
                                         OffsetExample{"M60M80",
                                                       "X50.Y80.",
                                                       "X90.Y40.",
                                                       {{10, 70}, {10, 60}, {40, 60}, {40, 70}},
                                                       {{50, 30}, {50, 20}, {80, 20}, {80, 30}},
                                                       {20, 70},
                                                       {60, 30}},
                                         OffsetExample{"M60M90",
                                                       "X10.Y90.",
                                                       "X50.Y50.",
                                                       {{50, 80}, {50, 70}, {20, 70}, {20, 80}},
                                                       {{90, 40}, {90, 30}, {60, 30}, {60, 40}},
                                                       {40, 80},
                                                       {80, 40}},
                                         // Printed Y80 and Y40 for the first two lines are slips:
                                         // Y_M70 = Y_Ref - Y_Act, so Y90, Y50.
                                         OffsetExample{"M70",
                                                       "X40.Y50.",
                                                       "X80.Y10.",
                                                       {{30, 90}, {20, 90}, {20, 60}, {30, 60}},
                                                       {{70, 50}, {60, 50}, {60, 20}, {70, 20}},
                                                       {30, 80},
                                                       {70, 40}},
                                         OffsetExample{"M80",
                                                       "X10.Y90.",
                                                       "X60.Y60.",
                                                       {{20, 50}, {30, 50}, {30, 80}, {20, 80}},
                                                       {{70, 20}, {80, 20}, {80, 50}, {70, 50}},
                                                       {20, 60},
                                                       {70, 30}},
                                         OffsetExample{"M90",
                                                       "X40.Y90.",
                                                       "X80.Y60.",
                                                       {{30, 50}, {20, 50}, {20, 80}, {30, 80}},
                                                       {{70, 20}, {60, 20}, {60, 50}, {70, 50}},
                                                       {30, 60},
                                                       {70, 30}}),
                         command_of);

// --- chapter 5.5, M50V2: Pattern Repetition ------------------------------------------------------

Places at(double x_mm, double y_mm) {
  return {{x_mm, y_mm}};
}

TEST(ManualM50V2, PatternRow) {
  const ProgramRun run = run_5000(
      "(SECTION T1)\nX10.Y20.T1 M31 M31\nX0Y0 M50V2\nX440.Y M50W5 M30\n"
      "(SECTION T2)\nX15.Y25.T2 M31\nX0Y0 M50V2\nX440.Y M50W5 M30\n"
      "(FINAL OFFSET)\nX123.45Y23.65 M50 M30\n");
  Places row;  // five patterns of 100 mm, 10 mm apart
  for (const double zero_mm : {0, 110, 220, 330, 440}) row.emplace_back(zero_mm, 0);
  const Vector2d final_offset(123.45, 23.65);
  expect_places(hole_places(run),
                joined(shifted(row, final_offset + Vector2d(10, 20)),
                       shifted(row, final_offset + Vector2d(15, 25))));
  EXPECT_EQ(
      paths(run),
      (Paths{{0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}}));
  EXPECT_EQ(run.executed.tools().size(), 2U);
}

TEST(ManualM50V2, PatternColumn) {
  const ProgramRun run = run_5000(
      "(SECTION T1)\nX10.Y20.T1 M31 M31\nX0Y0 M50V2\nXY320. M50W3 M30\n"
      "(SECTION T2)\nX15.Y25.T2 M31\nX0Y0 M50V2\nXY320. M50W3 M30\n"
      "(FINAL OFFSET)\nX123.45Y23.65 M50 M30\n");
  const Places column = {{0, 0}, {0, 160}, {0, 320}};
  const Vector2d final_offset(123.45, 23.65);
  expect_places(hole_places(run),
                joined(shifted(column, final_offset + Vector2d(10, 20)),
                       shifted(column, final_offset + Vector2d(15, 25))));
}

/// "Two M31 commands are at the beginning of every section. There are even three M31 commands at
/// the beginning of the 1st section."
TEST(ManualM50V2, PatternFieldRunsRowByRow) {
  const std::string field = "X0Y0 M50V2\nX440.Y M50W5 M30\nX0Y0 M50V2\nXY320. M50W3 M30\n";
  const ProgramRun run = run_5000("( SECTION T1 )\nX10.Y20.T1 M31M31 M31\n" + field +
                                  "( SECTION T2 )\nX15.Y25.T2 M31M31\n" + field +
                                  "(FINAL OFFSET)\nX123.45Y23.65 M50 M30\n");
  Places zeros;
  Paths expected_paths;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 5; ++column) {
      zeros.emplace_back(110 * column, 160 * row);
      expected_paths.push_back({0, row, column});
    }
  }
  const Vector2d final_offset(123.45, 23.65);
  ASSERT_EQ(run.holes().size(), 30U);
  expect_places(hole_places(run),
                joined(shifted(zeros, final_offset + Vector2d(10, 20)),
                       shifted(zeros, final_offset + Vector2d(15, 25))));
  const Paths found = paths(run);
  EXPECT_EQ(Paths(found.begin(), found.begin() + 15), expected_paths);
  EXPECT_EQ(Paths(found.begin() + 15, found.end()), expected_paths);
}

// --- chapter 5.1: Tool Change --------------------------------------------------------------------

// The listings mix M25 and M08 into their brackets' places, in each listing differently. M08 is no
// command of this language (appendix B), so both are left out.
constexpr char kFirstTool[] = "X0.000 Y0.000 T00 T01\nX0.000 Y0.000G45R20.F10\nX0.000 Y0.000 T0\n";
constexpr char kSecondTool[] = "X10.000 Y-20.000 T02\nX20.000 Y-10.000\n";
constexpr char kTwoPatterns[] = "(OFFSET COMMANDS)\nX25.000 Y25.000 M50\nX75.000 Y75.000 M50\n";

Lines tool_steps(const ProgramRun& run) {
  Lines out;
  for (const std::string& step : steps_of(run)) {
    if (step.starts_with("tool")) out.push_back(step);
  }
  return out;
}

/// "The execution of the program is repeated (including all tool changes)."
TEST(ManualToolChange, OffsetsAtTheEndRepeatToolChanges) {
  const ProgramRun run = run_5000(std::string(kFirstTool) + kSecondTool + kTwoPatterns);
  EXPECT_EQ(tool_steps(run), (Lines{"tool 1 [0]", "tool 2 [0]", "tool 1 [1]", "tool 2 [1]"}));
  expect_places(hole_places(run), {{35, 5}, {45, 15}, {85, 55}, {95, 65}});
}

TEST(ManualToolChange, OffsetsBehindEverySectionDoNot) {
  const ProgramRun run =
      run_5000(std::string(kFirstTool) + kTwoPatterns + kSecondTool + kTwoPatterns);
  EXPECT_EQ(tool_steps(run), (Lines{"tool 1 [0]", "tool 2 [0]"}));
  expect_places(hole_places(run), {{35, 5}, {45, 15}, {85, 55}, {95, 65}});
}

// --- chapters 5.2 and 5.3: Program Section, Step-and-Repeat --------------------------------------

TEST(ManualBrackets, CompleteOffsetOfTwoSections) {
  const ProgramRun run = run_5000(
      "X10.Y30.T1 M31 M31\nX30.Y40.M50\nX70.Y20.M50 M30\n"
      "X10.Y30.T2 M31\nX30.Y40.M50\nX70.Y20.M50 M30\n"
      "(FINAL OFFSET)\nX123.45Y234.67M50 M30\n");
  const Places section = shifted({{40, 70}, {80, 50}}, Vector2d(123.45, 234.67));
  expect_places(hole_places(run), joined(section, section));
  EXPECT_EQ(paths(run), (Paths{{0, 0}, {0, 1}, {0, 0}, {0, 1}}));
  EXPECT_EQ(tool_steps(run), (Lines{"tool 1 [0,0]", "tool 2 [0,0]"}));
}

TEST(ManualStepAndRepeat, CirclesOfTwoToolsAreShiftedAsAWhole) {
  const ProgramRun run = run_5000(
      "(SECTION: T5)\nX0.000Y0.000T0T5 M31 M31\nX0.000Y0.000G45R20. F1.2\nX0.000Y0.000T0\n"
      "(STEP-AND-REPEAT)\nX0Y0 M50\nX75.000Y75.000 M50 M30\n"
      "(SECTION: T6)\nX30.000Y40.000T0T6 M31\nX30.000Y40.000G45R20.\nX30.000Y40.000T0\n"
      "(STEP-AND-REPEAT)\nX0Y0 M50\nX75.000Y75.000 M50 M30\n"
      "(FINAL OFFSET)\nX123.43Y536.224 M50 M30\n");
  // The T0 lines position to the circles' centres, with the tool up.
  for (const char* center : {"position (123.43, 536.224) [0,0]",
                             "position (198.43, 611.224) [0,1]",
                             "position (153.43, 576.224) [0,0]",
                             "position (228.43, 651.224) [0,1]"}) {
    EXPECT_THAT(steps_of(run), Contains(center));
  }
  EXPECT_EQ(std::ranges::count_if(
                steps_of(run), [](const std::string& step) { return step.starts_with("plunge"); }),
            4);
}

/// Every copy positions to its own start, also where the program's coordinate is the one at which
/// the copy before ended.
TEST(ManualStepAndRepeat, AClosedContourBeginsAtItsStartInEveryCopy) {
  const ProgramRun run =
      run_5000("XYT0T5M31\nX10.YG1F1.\nX10.Y10.\nXY\nXYT0\nX50.YM50\nX100.YM50M30\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 5 [0]",
                          "position (50, 0) [0]",
                          "plunge [0]",
                          "rout 5 line (60, 0) [0]",
                          "rout 5 line (60, 10) [0]",
                          "rout 5 line (50, 0) [0]",
                          "retract [0]",
                          "position (100, 0) [1]",
                          "plunge [1]",
                          "rout 5 line (110, 0) [1]",
                          "rout 5 line (110, 10) [1]",
                          "rout 5 line (100, 0) [1]",
                          "retract [1]"));
}

/// "If at least one offset command is programmed at the end of a program section, only this (or
/// these) offset command(s) is (are) considered."
TEST(ManualStepAndRepeat, OneOffsetMovesTheSection) {
  expect_places(hole_places(run_5000("X1.Y2.T1M31\nX10.Y20.M50M30\n")), at(11, 22));
}

/// "For execution of a program section exactly at the programmed position and additional shifted
/// execution at least two offset lines must be programmed."
TEST(ManualStepAndRepeat, TheProgrammedPositionNeedsAnOffsetOfItsOwn) {
  expect_places(hole_places(run_5000("X1.Y2.T1M31\nXYM50\nX10.Y20.M50M30\n")), {{1, 2}, {11, 22}});
}

TEST(ManualStepAndRepeat, ASectionWithoutOffsetsStandsWhereItIs) {
  const ProgramRun run = run_5000("X1.Y2.T1M31\nX3.Y4.M30\nX5.Y6.\n");
  expect_places(hole_places(run), {{1, 2}, {3, 4}, {5, 6}});
  EXPECT_EQ(paths(run), (Paths{{}, {}, {}}));
}

/// "Up to 6 (CNC 8x.00) bracketed program sections can be nested"; "the number of original patterns
/// multiplies with every repetition" (glossary, Nested Step-and-Repeat).
TEST(ManualStepAndRepeat, SixNestedSectionsMultiply) {
  std::string body = "XYT1M31M31M31M31M31M31\n";
  for (int level = 0; level < 6; ++level) {
    body += "XYM50\nX" + std::to_string(1 << level) + ".YM50M30\n";
  }
  Places expected;
  for (int i = 0; i < 64; ++i) expected.emplace_back(i, 0);
  const ProgramRun run = run_5000(body);
  expect_places(hole_places(run), expected);
  ASSERT_EQ(run.holes().size(), 64U);
  EXPECT_EQ(run.holes()[5].path, (InstancePath{0, 0, 0, 1, 0, 1}));
}

// --- chapter 5.4: Zero Point Calculation ---------------------------------------------------------

constexpr char kTwoSections[] =
    "XYM50\nX100.YM50M30\nX30.Y20.T2M31\nXYM50\nX100.YM50M30\n(COMPLETE ROTATION)\n";

TEST(ManualZeroPoint, CompleteRotation) {
  const ProgramRun run =
      run_5000("X10.Y20.T1M31 M31\n" + std::string(kTwoSections) + "XY M60M90 M30\n");
  expect_places(hole_places(run), {{20, -10}, {20, -110}, {20, -30}, {20, -130}});
}

TEST(ManualZeroPoint, CompleteRotationThenCompleteOffset) {
  const ProgramRun run = run_5000("X10.Y20.T1M31 M31 M31\n" + std::string(kTwoSections) +
                                  "XY M60M90 M30\n(FINAL OFFSET)\nX123.34Y-223.11 M50 M30\n");
  expect_places(hole_places(run),
                shifted({{20, -10}, {20, -110}, {20, -30}, {20, -130}}, Vector2d(123.34, -223.11)));
  EXPECT_EQ(paths(run), (Paths{{0, 0, 0}, {0, 0, 1}, {0, 0, 0}, {0, 0, 1}}));
}

// --- chapter 8.1: G90 and G91 --------------------------------------------------------------------

TEST(ManualG91, ContourOfAbsoluteAndIncrementalLines) {
  const ProgramRun run = run_5000(
      "X20.Y-30. T0T5 M31\nX20.Y-20. G1F1.2G42\nX30.Y-20.\nX30.Y\nX20.Y\nX20.Y30.\nX-20.Y10.\n"
      "Y-20.X G91\nX-20.Y\nXY-10.\nX10.Y-10.\nX20.Y-30. G90\nX20.Y-30. T0\n"
      "(FINAL OFFSET)\nX80.Y70.M50M30\n");
  expect_places(rout_ends(run),
                shifted({{20, -20},
                         {30, -20},
                         {30, 0},
                         {20, 0},
                         {20, 30},
                         {-20, 10},
                         {-20, -10},
                         {-40, -10},
                         {-40, -20},
                         {-30, -30},
                         {20, -30}},
                        Vector2d(80, 70)));
}

/// "At the beginning of the program the last used absolute coordinate will be set to X0Y0."
TEST(ManualG91, BeginsAtProgramZero) {
  expect_places(hole_places(run_5000("X5.Y5.T1G91\nX5.Y\nX1.Y1.G90\n")), {{5, 5}, {10, 5}, {1, 1}});
}

/// "Before an offset command is executed the CNC automatically switches to the absolute
/// interpretation"; the reference is set anew "at the end of a Step-and-Repeat pattern".
TEST(ManualG91, OffsetsAreAbsoluteAndEndIt) {
  const ProgramRun run =
      run_5000("X10.Y10.T1M31\nX5.Y5.G91\nX100.Y100.M50\nX200.Y200.M50M30\nX7.Y8.\nX1.YG91\n");
  expect_places(hole_places(run), {{110, 110}, {115, 115}, {210, 210}, {215, 215}, {7, 8}, {8, 8}});
}

// --- chapter 8.5: T, and chapter 1: Working method -----------------------------------------------

/// The listing has lost the second line of V2; three holes 10 mm apart stand in for it.
TEST(ManualT, PartProgramWithToolChanges) {
  const ProgramRun run = run_5000(
      "X0.Y0.V2 T1 M31 M31\nX20.Y0.W3\nXYM50\nXY100.M50 M30\n"
      "X25.Y50. T0 T2 M31\nX25.Y50. G45 R20.\nX25.Y50. T0\nXYM50\nXY100.M50 M30\n"
      "(FINAL OFFSET)\nX123.45Y345.67M50 M30\n");
  expect_places(hole_places(run),
                shifted({{0, 0}, {10, 0}, {20, 0}, {0, 100}, {10, 100}, {20, 100}},
                        Vector2d(123.45, 345.67)));
  EXPECT_EQ(tool_steps(run), (Lines{"tool 1 [0,0]", "tool 2 [0,0]"}));
  EXPECT_THAT(steps_of(run), Contains("position (148.45, 395.67) [0,0]"));
  EXPECT_THAT(steps_of(run), Contains("position (148.45, 495.67) [0,1]"));
}

/// "A T0 command programmed within a drilling program prevents lowering the Z-axis."
TEST(ManualT, T0WhileDrillingKeepsTheToolUp) {
  EXPECT_THAT(steps_of(run_5000("X10.Y10.T1\nX20.Y20.T0\nX30.Y30.\n")),
              ElementsAre("tool 1", "drill 1 (10, 10)", "position (20, 20)", "drill 1 (30, 30)"));
}

/// "X..Y..T2 means that the tool is changed to T2 first and then the XY-position is drilled."
TEST(ManualWorkingMethod, ACommandBehindTheCoordinatesActsOnThem) {
  EXPECT_THAT(
      steps_of(run_5000("X10.Y10.T1\nX10.Y20.T2\nX10.Y30.\n")),
      ElementsAre("tool 1", "drill 1 (10, 10)", "tool 2", "drill 2 (10, 20)", "drill 2 (10, 30)"));
}

/// "If contradictory commands are programmed in a program line, the CNC considers the last command
/// of the program line."
TEST(ManualWorkingMethod, TheLastOfContradictoryCommandsRules) {
  EXPECT_THAT(steps_of(run_5000("X10.Y10.T1T2\nX5.Y5.G91G90\nX6.Y7.X8.\n")),
              ElementsAre("tool 2", "drill 2 (10, 10)", "drill 2 (5, 5)", "drill 2 (8, 7)"));
}

/// "If there is already a tool of the selected tool number in the spindle, the tool change is not
/// carried out."
TEST(ManualT, TheSameToolIsNotChanged) {
  EXPECT_THAT(steps_of(run_5000("X10.Y10.T1\nX20.Y20.T1\n")),
              ElementsAre("tool 1", "drill 1 (10, 10)", "drill 1 (20, 20)"));
}

}  // namespace
}  // namespace panelcal
