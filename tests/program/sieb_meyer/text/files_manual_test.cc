// SPDX-License-Identifier: Apache-2.0
// SIEB & MEYER manual, appendix A (File Format), chapter 6 (Subprograms), 8.3 and 8.4 (what the
// machine does by itself) and 8.5, `(` and `/`.
#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/files/digest.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::ended;
using test::expect_places;
using test::hole_places;
using test::IsNearMatrix;
using test::joined;
using test::Places;
using test::ProgramRun;
using test::run_5000;
using test::run_program;
using test::says;
using test::shifted;
using test::steps_of;
using test::SubprogramFolder;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

using Lines = std::vector<std::string>;

constexpr double kMmPerSOfOneMPerMin = 1000.0 / 60;

// --- appendix A.5 to A.7: the three formats ------------------------------------------------------

constexpr char kComments[] = "PROGRAM EXAMPLE\nCREATED 18.07.89\nMODIFIED 22.07.89\n";

/// Row of a tool table for one tool, in the manual's units.
struct ToolRow {
  double diameter_mm;
  double speed_rpm;
  double infeed_m_min;
  double retract_m_min;
  int strokes;
};

void expect_tool(const Program& program, int number, const ToolRow& row) {
  const auto found = program.tools().find(number);
  ASSERT_NE(found, program.tools().end()) << "T" << number;
  const Tool& tool = found->second;
  ASSERT_TRUE(tool.diameter && tool.speed && tool.infeed && tool.retract && tool.max_hits);
  EXPECT_NEAR(tool.diameter->in_mm(), row.diameter_mm, 1e-9);
  EXPECT_NEAR(tool.speed->in_rpm(), row.speed_rpm, 1e-6);
  EXPECT_NEAR(tool.infeed->in_mm_s(), row.infeed_m_min * kMmPerSOfOneMPerMin, 1e-9);
  EXPECT_NEAR(tool.retract->in_mm_s(), row.retract_m_min * kMmPerSOfOneMPerMin, 1e-9);
  EXPECT_EQ(*tool.max_hits, row.strokes);
}

void expect_clean(const ProgramRun& run) {
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
}

/// "The number of all '$' given out must always be 91": two tools, and six values of each of the
/// thirteen others left out.
std::string format_1000_tools() {
  return "$80$50$20$99$30$300$200$40$22$99$30$$" + std::string(13 * 6, '$') + "\n";
}

TEST(ManualFormat1000, Example) {
  const std::string tools = format_1000_tools();
  ASSERT_EQ(std::ranges::count(tools, '$'), 91);
  const ProgramRun run =
      run_program(std::string(kComments) +
                  "%%\nX1000Y1000T1\nX3456Y4567\nX12345Y450\nX4000Y4000T2T0\nX6000Y4000G1F15\n"
                  "X6000Y7000G1\nX7000Y6000T0\n" +
                  tools);
  expect_clean(run);
  EXPECT_EQ(run.program.dialect, Dialect::SiebMeyer);
  EXPECT_THAT(run.executed.lines(),
              ElementsAre("5 tool 1",
                          "5 drill 1 (10, 10)",
                          "6 drill 1 (34.56, 45.67)",
                          "7 drill 1 (123.45, 4.5)",
                          "8 tool 2",
                          "8 position (40, 40)",
                          "9 plunge",
                          "9 rout 2 line (60, 40)",
                          "10 rout 2 line (60, 70)",
                          "11 retract",
                          "11 position (70, 60)"));
  EXPECT_NEAR(run.executed.routs()[0].feed.in_mm_s(), 1.5 * kMmPerSOfOneMPerMin, 1e-9);
  expect_tool(run.program, 1, {0.8, 50000, 2.0, 9.9, 3000});
  expect_tool(run.program, 2, {2.0, 40000, 2.2, 9.9, 3000});
}

/// The table under the example has N30 for T1; the listing has N10, which is 1000 strokes.
TEST(ManualFormat3000, Example) {
  const ProgramRun run = run_program(
      std::string(kComments) +
      "%%3000\nX10.Y10.T1\nX.3Y.45\nX123.45Y.451\nX40.Y40.T1T0\nX60.Y40.G1F15\nX60.Y70.\n"
      "X60.Y70.T0\n$\nT1D80S50F20R150N10A300\nM1M2M3\nT2D200S40F22R150N30\n"
      "M4M5M6M7M8M9M10M11M12M13\nM14M15M16\n$\n");
  expect_clean(run);
  EXPECT_THAT(run.executed.lines(),
              ElementsAre("5 tool 1",
                          "5 drill 1 (10, 10)",
                          "6 drill 1 (0.3, 0.45)",
                          "7 drill 1 (123.45, 0.451)",
                          "8 position (40, 40)",
                          "9 plunge",
                          "9 rout 1 line (60, 40)",
                          "10 rout 1 line (60, 70)",
                          "11 retract"));
  EXPECT_NEAR(run.executed.routs()[0].feed.in_mm_s(), 1.5 * kMmPerSOfOneMPerMin, 1e-9);
  expect_tool(run.program, 1, {0.8, 50000, 2.0, 15.0, 1000});
  expect_tool(run.program, 2, {2.0, 40000, 2.2, 15.0, 3000});
}

/// The listing has %%3000 and F15 of the example before; its tool table is format 5000's. R25. is
/// 25 m/min, although the table under it says "R25. = 15.0 m/min".
TEST(ManualFormat5000, Example) {
  const ProgramRun run = run_program(
      std::string(kComments) +
      "%%5000\nX10.Y10.T1\nX.3Y.45\nX123.45Y.451\nX40.Y40.T1T0\nX60.Y40.G1F1.5\nX60.Y70.\n"
      "X60.Y70.T0\n$\nT1D.8S50.F2.R25.N3000A.3\nM1M2M3\nT2D2.S40.F2.2R25.N3000Z.3A.3\n"
      "M4M5M6M7M8M9M10M11M12M13\nM14M15M16\n$\n");
  expect_clean(run);
  EXPECT_EQ(run.holes().size(), 3U);
  EXPECT_EQ(run.executed.lines()[1], "5 drill 1 (10, 10)");
  EXPECT_EQ(run.executed.lines().back(), "11 retract");
  expect_tool(run.program, 1, {0.8, 50000, 2.0, 25.0, 3000});
  expect_tool(run.program, 2, {2.0, 40000, 2.2, 25.0, 3000});
  EXPECT_EQ(run.program.tools().at(2).depth_offset, mm(0.3));
  // "Tool change" passes the table's data on.
  ASSERT_EQ(run.executed.tools().size(), 1U);
  EXPECT_EQ(run.executed.tools()[0].diameter, mm(0.8));
}

/// "X1 = 0.01 mm" in format 1000, "X1 = 0.001 mm" from 3000 on.
TEST(ManualFormats, CoordinatesWithoutAPoint) {
  expect_places(hole_places(run_program(ended("%%\nX1234Y-5T1\n"))), {{12.34, -0.05}});
  expect_places(hole_places(run_program(ended("%%3000\nX1234Y-5T1\n"))), {{1.234, -0.005}});
  expect_places(hole_places(run_program(ended("%%5000\nX1234Y-5T1\n"))), {{1.234, -0.005}});
}

/// "If only the code letter is saved for a parameter, the corresponding value in the tool table is
/// reset to zero"; "if identical code letters with different values are given out for one tool
/// number, the CNC uses the last value".
TEST(ManualToolTable, LastValueRules) {
  const ProgramRun run = run_program("%%5000\nXYT1\n$\nT1D.8S50D.9\n$\n");
  expect_clean(run);
  EXPECT_EQ(run.program.tools().at(1).diameter, mm(0.9));
}

/// "If no code letter is saved for a parameter, the corresponding value in the tool table remains
/// unchanged": the file says nothing of it.
TEST(ManualToolTable, WhatIsNotSaidIsAbsent) {
  const ProgramRun run = run_program("%%5000\nXYT1\n$\nT1D.8\n$\n");
  expect_clean(run);
  EXPECT_EQ(run.program.tools().at(1).speed, std::nullopt);
  EXPECT_EQ(run.program.tools().at(1).infeed, std::nullopt);
}

// --- appendix A.3 and A.4: program lines ---------------------------------------------------------

/// The example of a program's structure; X34567Y45678 is 34.567 and 45.678 mm.
TEST(ManualProgramLine, StructureExample) {
  const ProgramRun run = run_5000(
      "X12.345Y34.567T1M31\nX50.Y76.T0\nX55.Y76.G1F1.2\nX55.Y76.T0\nX100.Y300.T7M97,ABC\n"
      "X34567Y45678M50M30\n");
  ASSERT_GT(run.holes().size(), 10U);
  EXPECT_THAT(run.holes().front().nominal_mm(),
              IsNearMatrix(Vector2d(12.345 + 34.567, 34.567 + 45.678), 1e-9));
  EXPECT_THAT(run.executed.routs().front().nominal.in_mm(),
              IsNearMatrix(Vector2d(55 + 34.567, 76 + 45.678), 1e-9));
  EXPECT_EQ(run.holes().back().drill.tool, 7);
}

class ManualLineEnd : public testing::TestWithParam<std::string_view> {};

/// Line feed, carriage return, line feed and carriage return, carriage return and line feed.
TEST_P(ManualLineEnd, EndsExactlyOneLine) {
  std::string text = "COMMENT\n%%5000\nX1.Y2.T1\nX3.Y4.\n$\nT1D1.\n$\n";
  for (std::size_t at = text.find('\n'); at != text.npos; at = text.find('\n', at)) {
    text.replace(at, 1, GetParam());
    at += GetParam().size();
  }
  const ProgramRun run = run_program(text);
  expect_clean(run);
  EXPECT_THAT(run.executed.lines(),
              ElementsAre("3 tool 1", "3 drill 1 (1, 2)", "4 drill 1 (3, 4)"));
  EXPECT_TRUE(run.program.tools().contains(1));
}

INSTANTIATE_TEST_SUITE_P(AppendixA4, ManualLineEnd, testing::Values("\n", "\r", "\n\r", "\r\n"));

TEST(ManualProgramLine, SixtyFourSignsAreTheMost) {
  const std::string line = "X1.Y2.T1(";
  const auto filled = [&](std::size_t size) {
    return ended("%%5000\n" + line + std::string(size - line.size() - 1, '-') + ")\n");
  };
  const ProgramRun full = run_program(filled(64));
  EXPECT_THAT(full.texts, Not(Contains(HasSubstr("64"))));
  const ProgramRun too_long = run_program(filled(65));
  expect_clean(too_long);  // the machine reads it, so it is a warning
  EXPECT_THAT(too_long.texts, Contains(AllOf(says(2, "64"), HasSubstr("warning["))));
  EXPECT_EQ(too_long.holes().size(), 1U);
}

// --- chapter 8.5: comments and labelled lines ----------------------------------------------------

/// "Comments are entered in round brackets and can be programmed alone in a line or at the end of a
/// program line."
TEST(ManualComment, StandsAloneOrBehindALine) {
  const ProgramRun run =
      run_5000("(TOOLING HOLES X5.Y5.)\nX1.Y2.T1 (FIRST HOLE T9)\n( SECTION T2 )\nX3.Y4.\n(\n");
  expect_places(hole_places(run), {{1, 2}, {3, 4}});
  EXPECT_EQ(run.executed.tools().size(), 1U);
}

TEST(ManualSlash, BlkdIgnoresLabelledLines) {
  ReadOptions reading;
  reading.block_delete = true;
  expect_places(hole_places(run_5000("X1.Y2.T1\n/X3.Y4.\nX5.Y6.\n", {}, reading)),
                {{1, 2}, {5, 6}});
}

TEST(ManualSlash, NoblkdExecutesThem) {
  ReadOptions reading;
  reading.block_delete = false;
  expect_places(hole_places(run_5000("X1.Y2.T1\n/X3.Y4.\nX5.Y6.\n", {}, reading)),
                {{1, 2}, {3, 4}, {5, 6}});
}

// --- chapter 6: Subprograms ----------------------------------------------------------------------

constexpr char kReset[] = "@RESET\nM49,NOFA\nM49,NORA\nM49,NOSA\n";
constexpr char kFinal[] = "@FINAL\nXYT99\nXY500.\nX300.Y500.\nX300.Y\n";

Places final_holes() {
  return {{0, 0}, {0, 500}, {300, 500}, {300, 0}};
}

/// Drills X1.Y2. with T1, calls, drills X3.Y4.
std::string calling(const std::string& calls) {
  return "X1.Y2.T1\n" + calls + "X3.Y4.T1\n";
}

TEST(ManualSubprogram, FinalIsDrilledAtItsZeroPoint) {
  SubprogramFolder folder;
  folder.with("TOOLING.SS5", std::string(kReset) + kFinal);
  const ProgramRun run =
      run_5000(calling("X100.Y50.M99,FINAL\nXYM99,FINAL\n"), {}, folder.reading());
  expect_places(
      hole_places(run),
      joined(joined(joined({{1, 2}}, shifted(final_holes(), Vector2d(100, 50))), final_holes()),
             {{3, 4}}));
  EXPECT_EQ(run.holes()[1].drill.tool, 99);
  EXPECT_EQ(run.holes().back().drill.tool, 1);
  // Subprograms add nothing to the path, and their holes have their own file's lines.
  EXPECT_EQ(run.holes()[1].path, InstancePath{});
  EXPECT_EQ(run.holes()[1].line, 6);
}

/// CSUB: "Every subprogram is saved in a separate file. The file name and the subprogram name are
/// the same (except for '@')."
TEST(ManualSubprogram, MayHaveAFileOfItsOwn) {
  SubprogramFolder folder;
  folder.with("FINAL.SS5", kFinal).with("RESET.SS5", kReset);
  const ProgramRun run = run_5000(calling("XYM99,FINAL\n"), {}, folder.reading());
  expect_places(hole_places(run), joined(joined({{1, 2}}, final_holes()), {{3, 4}}));
  EXPECT_EQ(run.holes()[1].line, 2);
}

TEST(Subprogram, WhatItAsksForNamesItsContent) {
  const std::string text = "@LOOK\nX10.Y10.G32\nG31\nG71K.4\nX20.Y20.G73L1\nG70\n";
  SubprogramFolder folder;
  folder.with("LOOK.SS5", text);
  const ProgramRun run =
      run_program(test::format_5000("XYM99,LOOK\nX5.Y5.G32\nG31\n"), {}, folder.reading());
  ASSERT_EQ(run.survey.measurements.size(), 2U) << testing::PrintToString(run.diagnostics);
  EXPECT_EQ(run.survey.measurements[0].request.file_sha256, sha256(text));
  EXPECT_EQ(run.survey.measurements[1].request.file_sha256, "");  // of the program itself
  ASSERT_EQ(run.survey.probes.size(), 1U) << testing::PrintToString(run.diagnostics);
  EXPECT_EQ(run.survey.probes[0].request.file_sha256, sha256(text));
}

/// A subprogram that another one or a dollar sign follows is whole; the last one needs its line
/// end.
TEST(ManualSubprogram, ThatIsCutOffInItsLastLineIsRefused) {
  const auto is_refused = [](const std::string& text) {
    SubprogramFolder folder;
    folder.with("PINS.SS5", text);
    const ProgramRun run =
        run_program(test::format_5000(calling("XYM99,PINS\n")), {}, folder.reading());
    if (run.has_errors) {
      EXPECT_THAT(run.texts, Contains(HasSubstr("error[end-missing]")));
    }
    return run.has_errors;
  };
  EXPECT_TRUE(is_refused("@PINS\nX1.Y1.T1\nX2"));
  EXPECT_TRUE(is_refused("@PINS"));
  EXPECT_FALSE(is_refused("@PINS\nX1.Y1.T1\nX2.\n"));
  EXPECT_FALSE(is_refused("@PINS\nX1.Y1.T1\nX2.\n@OTHER\nX3"));
  EXPECT_FALSE(is_refused("@PINS\nX1.Y1.T1\nX2.\n$"));
}

/// The part program of M99's example, with holes of its own. FA sets program zero, so that the
/// machine goes to other places while the program's stay what they are; NOFA takes it back.
TEST(ManualSubprogram, ResetFinalReset) {
  SubprogramFolder folder;
  folder.with("TOOLING.SS5", std::string(kReset) + kFinal);
  const ProgramRun run =
      run_5000("XYM99,RESET\nM49,FAX123.432Y256.753\nXYM99,FINAL\nXYM99,RESET\nX1.Y2.T1\n",
               {},
               folder.reading());
  expect_places(hole_places(run), joined(final_holes(), {{1, 2}}));
  for (std::size_t i = 0; i < run.holes().size(); ++i) {
    const Vector2d zero = i < 4 ? Vector2d(123.432, 256.753) : Vector2d(0, 0);
    EXPECT_THAT(run.holes()[i].actual_mm(),
                IsNearMatrix(Vector2d(run.holes()[i].nominal_mm() + zero), 1e-9));
  }
}

/// "At the end of a subprogram the routing track is terminated automatically (corresponds to the
/// command T0)."
TEST(ManualSubprogram, EndsItsRoutingTrack) {
  SubprogramFolder folder;
  folder.with("SLOT.SS5", "@SLOT\nXYT0T5\nX10.YG1F1.\n");
  const ProgramRun run = run_5000("X20.Y30.M99,SLOT\nX50.Y50.\n", {}, folder.reading());
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 5",
                          "position (20, 30)",
                          "plunge",
                          "rout 5 line (30, 30)",
                          "retract",
                          "drill 5 (50, 50)"));
}

/// "Additional commands (e.g. tool change T, bracket command M31 etc. must be programmed ahead of
/// the M99 command"; a called section is repeated as any other.
TEST(ManualSubprogram, IsRepeatedInASection) {
  SubprogramFolder folder;
  folder.with("PAIR.SS5", "@PAIR\nX1.Y\nX2.Y\n");
  const ProgramRun run =
      run_5000("X10.YT1M31M99,PAIR\nXYM50\nX100.YM50M30\n", {}, folder.reading());
  expect_places(hole_places(run), {{11, 0}, {12, 0}, {111, 0}, {112, 0}});
}

/// "A subprogram may call another subprogram."
TEST(ManualSubprogram, CallsAnotherOne) {
  SubprogramFolder folder;
  folder.with("ALL.SS5", "@OUTER\nX10.Y10.M99,INNER\nX20.Y20.M99,INNER\n@INNER\nX1.Y2.\n");
  const ProgramRun run = run_5000("XYT1\nX100.Y100.M99,OUTER\n", {}, folder.reading());
  expect_places(hole_places(run), {{0, 0}, {111, 112}, {121, 122}});
}

// --- chapters 8.3 and 8.4 ------------------------------------------------------------------------

TEST(ManualMachineFunctions, StandWhereTheyAreProgrammed) {
  const ProgramRun run =
      run_5000("M38\nX0Y0T1\nM34\nX10.Y10.T0T5\nX20.Y10.G1F1.\nX20.Y10.T0\nM35\nX0Y0\nM39\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("function machine_function M38",
                          "tool 1",
                          "drill 1 (0, 0)",
                          "function machine_function M34",
                          "tool 5",
                          "position (10, 10)",
                          "plunge",
                          "rout 5 line (20, 10)",
                          "retract",
                          "function machine_function M35",
                          "drill 5 (0, 0)",
                          "function machine_function M39"));
}

TEST(ManualMachineFunctions, FromM101OnAreCncCommands) {
  EXPECT_THAT(steps_of(run_5000("M49,M101\nX1.Y2.T1\n")),
              Contains("function machine_function M101"));
}

/// "The machine is stopped before this coordinate is executed."
TEST(ManualM20, StopsBeforeItsHole) {
  EXPECT_THAT(
      steps_of(run_5000("X1.Y2.T1\nX3.Y4.M20\n")),
      ElementsAre("tool 1", "drill 1 (1, 2)", testing::StartsWith("optional"), "drill 1 (3, 4)"));
}

/// "The axes are positioned after the coordinate has been executed."
TEST(ManualM28M29, ActBehindTheirHole) {
  EXPECT_THAT(steps_of(run_5000("X1.Y2.T1M28\nX3.Y4.M29\nM28\n")),
              ElementsAre("tool 1",
                          "drill 1 (1, 2)",
                          testing::StartsWith("function machine_zero"),
                          "drill 1 (3, 4)",
                          testing::StartsWith("function park_position"),
                          testing::StartsWith("function machine_zero")));
}

TEST(ManualM47, ShowsItsText) {
  const ProgramRun run = run_5000("M47,!TURN BOARD\nM47,&PTURN BOARD\nM47TURN BOARD\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("message !TURN BOARD", "message &PTURN BOARD", "message TURN BOARD"));
}

TEST(ManualM49, PassesCncCommandsOn) {
  EXPECT_THAT(steps_of(run_5000("M49,CHEKX100.Y10.DXDY10.\nX3.56Y-1.02T1\n")),
              ElementsAre("setting M49,CHEKX100.Y10.DXDY10.", "tool 1", "drill 1 (3.56, -1.02)"));
}

/// "The following CNC commands effect the direction of rotation: [...] ROV1"; "if the CNC command
/// INDX,D is set". What switches them off changes nothing.
TEST(ManualM49, PassesCommandsOnThatSwitchOffWhatIsRefused) {
  for (const std::string off : {"ROV0", "INDX,-D", "INDX,-D,-I"}) {
    EXPECT_THAT(steps_of(run_5000("M49," + off + "\nX1.Y2.T1\n")),
                ElementsAre("setting M49," + off, "tool 1", "drill 1 (1, 2)"));
  }
  for (const std::string on :
       {"ROV1", "ROV", "ROV00", "INDX", "INDX,D", "INDX,-D,I", "INDX,-", "INDX,-DI"}) {
    const ProgramRun run = run_program(test::format_5000("M49," + on + "\nX1.Y2.T1\n"));
    EXPECT_THAT(run.diagnostics, ElementsAre(HasSubstr("p.exc:2:5: error[not-supported]"))) << on;
  }
}

TEST(ManualM94M95, BreakageMonitoringIsPassedOnBeforeItsHole) {
  const ProgramRun run = run_5000("X1.Y2.T1M94\nX3.Y4.M95\n");
  EXPECT_THAT(steps_of(run),
              ElementsAre("tool 1",
                          testing::StartsWith("function breakage_check_off"),
                          "drill 1 (1, 2)",
                          testing::StartsWith("function breakage_check_on"),
                          "drill 1 (3, 4)"));
}

}  // namespace
}  // namespace panelcal
