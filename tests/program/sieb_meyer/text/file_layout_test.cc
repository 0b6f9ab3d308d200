// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/text/file_layout.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::sieb_meyer {
namespace {

using test::Reports;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::StartsWith;

constexpr double kMmPerSOfOneMPerMin = 1000.0 / 60;

struct Reading {
  FileLayout layout;
  std::vector<std::string> diagnostics;
  std::string body;  ///< the program lines

  /// Of a tool that must be there.
  const Tool& tool(int number) const {
    static const Tool kNone;
    const auto found = layout.tools.find(number);
    EXPECT_NE(found, layout.tools.end()) << "T" << number;
    return found == layout.tools.end() ? kNone : found->second;
  }
};

Reading read(const std::string& bytes) {
  DiagnosticLog log;
  Reading reading;
  reading.layout = read_layout({"p.ss", bytes}, log);
  for (const Diagnostic& diagnostic : log.kept()) {
    reading.diagnostics.push_back(diagnostic.text());
  }
  const std::size_t begin = reading.layout.body.offset;
  reading.body = bytes.substr(begin, reading.layout.body_end - begin);
  return reading;
}

/// The tool table of a file in format 5000 without program lines; its lines count from 3.
Reading read_table(const std::string& lines, const std::string& format = "5000") {
  return read("%%" + format + "\n$\n" + lines + "$\n");
}

/// The only diagnostic: its place, its code and the text that it names.
void expect_layout_refused(const Reading& reading,
                           const std::string& place,
                           const std::string& what) {
  EXPECT_THAT(reading.diagnostics,
              ElementsAre(Reports("p.ss:" + place + ": error[tool-table-invalid]", what)));
}

// --- whose file it is ----------------------------------------------------------------------------

TEST(IsProgram, TwoPercentSignsBeginOne) {
  EXPECT_TRUE(is_program("%%\nX1000Y1000T1\n"));
  EXPECT_TRUE(is_program("%%3000\n"));
  EXPECT_TRUE(is_program("%%5000"));
  EXPECT_TRUE(is_program("PROGRAM EXAMPLE\nCREATED 18.07.89\n\n  %%5000\r\nXY\r\n"));
  EXPECT_TRUE(is_program("%%\r\n"));
}

/// So that read_layout can say what is wrong with it.
TEST(IsProgram, TheFormatMayBeOneThatIsNotDescribed) {
  EXPECT_TRUE(is_program("%%5001\n"));
}

TEST(IsProgram, ExcellonFilesAreNone) {
  EXPECT_FALSE(is_program("M48\nMETRIC,LZ\nT1C1.\n%\nT1\nX1.Y1.\nM30\n"));
  EXPECT_FALSE(is_program("%\nT1\nX01Y01\nM30\n"));
  EXPECT_FALSE(is_program(" % \n%%5000\n"));
  EXPECT_FALSE(is_program("; made by hand\nM48\n%%\n"));
  EXPECT_FALSE(is_program("%1\n%%\n"));
  EXPECT_FALSE(is_program("M47,100%%\nX01Y01\n"));
  EXPECT_FALSE(is_program("X01Y01\nM30\n"));
  EXPECT_FALSE(is_program(""));
}

// --- parts ---------------------------------------------------------------------------------------

TEST(FileLayoutParts, AreCommentsProgramLinesAndTools) {
  const Reading reading =
      read("PROGRAM EXAMPLE\nCREATED 18.07.89\n%%5000\nX1.Y2.T1\nX3.Y4.\n$\nT1D1.\n$\n");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  EXPECT_EQ(reading.layout.head_line, 3);
  EXPECT_EQ(reading.layout.body.number, 4);
  EXPECT_EQ(reading.body, "X1.Y2.T1\nX3.Y4.\n");
  EXPECT_EQ(reading.layout.tools.size(), 1U);
}

/// "A $ sign closes the section tools parameters": a file without the table may have been cut off.
TEST(FileLayoutParts, AFileWithoutAToolTableHasNoEnd) {
  const Reading reading = read("%%\nX1Y2T1\nX3Y4");
  EXPECT_THAT(reading.diagnostics, ElementsAre(Reports("p.ss:3: error[end-missing]", "\"X3Y4\"")));
  EXPECT_EQ(reading.body, "X1Y2T1\nX3Y4");
  EXPECT_THAT(reading.layout.tools, IsEmpty());
  EXPECT_THAT(read("%%3000\nX1Y2T1\n").diagnostics,
              ElementsAre(Reports("p.ss:3: error[end-missing]", "\"X1Y2T1\"")));
  EXPECT_EQ(read("%%5000").body, "");
  EXPECT_EQ(read("%%5000\n").body, "");
}

TEST(FileLayoutParts, EveryLineEndWillDo) {
  for (const std::string end : {"\n", "\r", "\n\r", "\r\n"}) {
    const Reading reading =
        read("A" + end + "%%3000" + end + "X1Y2T1" + end + "$" + end + "T1D80" + end + "$" + end);
    EXPECT_THAT(reading.diagnostics, IsEmpty());
    EXPECT_EQ(reading.layout.head_line, 2);
    EXPECT_EQ(reading.body, "X1Y2T1" + end);
    EXPECT_EQ(reading.tool(1).diameter, mm(0.8));
  }
}

TEST(FileLayoutParts, TheFirstMarkStatesTheFormat) {
  EXPECT_EQ(read("%%\n").layout.format, FileFormat::F1000);
  EXPECT_EQ(read("%%1000\n").layout.format, FileFormat::F1000);
  EXPECT_EQ(read("%%3000\n").layout.format, FileFormat::F3000);
  EXPECT_EQ(read(" %%5000 \n").layout.format, FileFormat::F5000);
  EXPECT_EQ(read("%%3000\n%%5000\n").layout.format, FileFormat::F3000);
}

TEST(FileLayoutParts, OtherFormatsAreRefused) {
  for (const std::string mark : {"%%5001", "%%3010", "%%4000", "%%%", "%%5000 (A)", "%% 5000"}) {
    EXPECT_THAT(read("A\n" + mark + "\nX1.Y2.\n$\n$\n").diagnostics,
                ElementsAre(Reports("p.ss:2:1: error[command-format]", '"' + mark + '"')));
  }
}

TEST(FileLayoutParts, ADollarInsideALineIsNoTable) {
  const std::string lines = "X1.Y2.T1M97,A$B\n(PRICE $)\nM47,$$\n";
  const Reading reading = read("COST IN $\n$\n%%5000\n" + lines + "  $\nT1D1.\n$\n");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  EXPECT_EQ(reading.body, lines);
  EXPECT_EQ(read("%%5000\n" + lines).body, lines);
}

// --- formats 3000 and 5000: lines ----------------------------------------------------------------

/// The unit of every letter, A.6 and A.7. What the values mean together is files_manual_test's.
TEST(ToolTable, ReadsEveryDatumOfFormat5000) {
  const Reading reading = read_table("T7D.85S55F1.2R9.9N3000A1000Z.01\n");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  const Tool& tool = reading.tool(7);
  EXPECT_EQ(tool.number, 7);
  EXPECT_EQ(tool.diameter, mm(0.85));
  EXPECT_EQ(tool.speed, rpm(55000));
  ASSERT_TRUE(tool.infeed && tool.retract);
  EXPECT_NEAR(tool.infeed->in_mm_s(), 1.2 * kMmPerSOfOneMPerMin, 1e-9);
  EXPECT_NEAR(tool.retract->in_mm_s(), 9.9 * kMmPerSOfOneMPerMin, 1e-9);
  EXPECT_EQ(tool.max_hits, 3000);
  EXPECT_EQ(tool.depth_offset, mm(0.01));
  EXPECT_EQ(tool.dwell, seconds(1));
  EXPECT_EQ(reading.layout.tool_lines.at(7), 3);
}

TEST(ToolTable, ReadsEveryDatumOfFormat3000) {
  const Reading reading = read_table("T30D80S55F12R99N30A1000\n", "3000");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  const Tool& tool = reading.tool(30);
  EXPECT_EQ(tool.diameter, mm(0.8));
  EXPECT_EQ(tool.speed, rpm(55000));
  ASSERT_TRUE(tool.infeed && tool.retract);
  EXPECT_NEAR(tool.infeed->in_mm_s(), 1.2 * kMmPerSOfOneMPerMin, 1e-9);
  EXPECT_NEAR(tool.retract->in_mm_s(), 9.9 * kMmPerSOfOneMPerMin, 1e-9);
  EXPECT_EQ(tool.max_hits, 3000);
  EXPECT_EQ(tool.dwell, seconds(1));
}

/// "If only the code letter is saved for a parameter, the corresponding value in the tool table is
/// reset to zero."
TEST(ToolTable, ALetterWithoutANumberTakesTheDatumAway) {
  const Reading reading = read_table("T1D.8S50F2.R9.9N10A100Z.1\nT1DSFRNAZ\n");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  const Tool& tool = reading.tool(1);
  EXPECT_FALSE(tool.diameter || tool.speed || tool.infeed || tool.retract || tool.max_hits ||
               tool.depth_offset);
  EXPECT_FALSE(tool.dwell);
  EXPECT_EQ(tool.zeroed, "DSFRNAZ");
}

TEST(ToolTable, ADatumThatIsSetAgainIsNotZero) {
  EXPECT_EQ(read_table("T1DS0\nT1D.8\n").tool(1).zeroed, "S");
}

/// "If identical code letters with different values are given out for one tool number, the CNC uses
/// the last value"; "if no code letter is saved, ... remains unchanged".
TEST(ToolTable, TheLastDatumHoldsAndOthersStay) {
  const Reading reading = read_table("T1D.8S50D.9\nT2D2.\nT1S40\n");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  EXPECT_EQ(reading.tool(1).diameter, mm(0.9));
  EXPECT_EQ(reading.tool(1).speed, rpm(40000));
  EXPECT_EQ(reading.layout.tool_lines.at(1), 5);
}

TEST(ToolTable, AToolMayHaveNoData) {
  EXPECT_EQ(read_table("T5\n").tool(5).number, 5);
  EXPECT_FALSE(read_table("T5\n").tool(5).diameter);
}

TEST(ToolTable, MagazinesBelongToTheToolBefore) {
  const Reading reading =
      read_table("T1D1.\nM1M2M3\nT2D2.\nM4M5M6M7M8M9M10M11M12M13\nM14M15M16\nT3D1.\n");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  EXPECT_THAT(reading.tool(1).magazines, ElementsAre(1, 2, 3));
  EXPECT_THAT(reading.tool(2).magazines, ElementsAre(4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16));
  EXPECT_THAT(reading.tool(3).magazines, IsEmpty());
}

TEST(ToolTable, BlankLinesAndCommentsAreSkipped) {
  const Reading reading = read_table("\n(TOOLS)\n  T1 D1. (FIRST)\n \t\n");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  EXPECT_EQ(reading.tool(1).diameter, mm(1));
}

TEST(ToolTable, RefusesOtherLines) {
  expect_layout_refused(read_table("T1D1.\n  X1.Y1.\n"), "4:3", "\"X1.\"");
  expect_layout_refused(read_table("D1.T1\n"), "3:1", "\"D1.\"");
  expect_layout_refused(read_table("T1D1.=\n"), "3:6", "\"=\"");
  expect_layout_refused(read_table("t1D1.\n"), "3:1", "\"t\"");
}

TEST(ToolTable, RefusesOtherData) {
  expect_layout_refused(read_table("T1D1.K2.\n"), "3:6", "\"K2.\"");
  expect_layout_refused(read_table("T1Z10\n", "3000"), "3:3", "\"Z10\"");
  expect_layout_refused(read_table("T1T2\n"), "3:3", "\"T2\"");
}

TEST(ToolTable, RefusesBadNumbers) {
  expect_layout_refused(read_table("T1D1.2.\n"), "3:3", "\"D1.2.\"");
  expect_layout_refused(read_table("T1S50D-1.\n"), "3:6", "\"D-1.\"");
  expect_layout_refused(read_table("T1D.8\n", "3000"), "3:3", "\"D.8\"");
  expect_layout_refused(read_table("T1N3.5\n"), "3:3", "\"N3.5\"");
}

TEST(ToolTable, HasAsManyToolsAsTheFormat) {
  EXPECT_THAT(read_table("T99D1.\n").diagnostics, IsEmpty());
  expect_layout_refused(read_table("T100D1.\n"), "3:1", "\"T100\"");
  expect_layout_refused(read_table("T31D80\n", "3000"), "3:1", "\"T31\"");
  expect_layout_refused(read_table("T0D1.\n"), "3:1", "\"T0\"");
  expect_layout_refused(read_table("TD\n"), "3:1", "\"T\"");
}

TEST(ToolTable, RefusesMagazinesThatAreNone) {
  expect_layout_refused(read_table("M1M2\n"), "3:1", "\"M1\"");
  expect_layout_refused(read_table("T1D1.\nM1M0\n"), "4:3", "\"M0\"");
  expect_layout_refused(read_table("T1D1.\nM1X2\n"), "4:3", "\"X2\"");
  expect_layout_refused(read_table("T1D1.\nM1000\n"), "4:1", "\"M1000\"");
}

/// One refused line does not hide the next one.
TEST(ToolTable, ReportsEveryBadLine) {
  EXPECT_THAT(read_table("T1D1.K1\nT2D2.\nT3D-1\n").diagnostics,
              ElementsAre(StartsWith("p.ss:3:6: error["), StartsWith("p.ss:5:3: error[")));
}

TEST(ToolTable, BeginsWithADollarAlone) {
  expect_layout_refused(read("%%5000\nX1.Y1.T1\n$T1D1.\n$\n"), "3:1", "\"$T1D1.\"");
  expect_layout_refused(read("%%3000\n  $80$55$\n"), "2:1", "\"  $80$55$\"");
}

TEST(ToolTable, EndsWithADollar) {
  expect_layout_refused(read("%%5000\n$\nT1D1.\n"), "3", "");
  expect_layout_refused(read("%%5000\nX1.Y1.\n$\n"), "3", "");
  EXPECT_THAT(read("%%5000\n$\n$").diagnostics, IsEmpty());
}

TEST(ToolTable, WhatFollowsItIsReportedOnce) {
  EXPECT_THAT(read("%%5000\n$\nT1D1.\n$\n\n%%5000\nX1.Y1.\n$\n").diagnostics,
              ElementsAre(StartsWith("p.ss:6:1: warning[text-after-end]")));
}

// --- format 1000: ninety values ------------------------------------------------------------------

std::string repeated(const std::string& text, int n) {
  std::string out;
  for (int i = 0; i < n; ++i) out += text;
  return out;
}

Reading read_1000(const std::string& table) {
  return read("%%\nX1000Y1000T1\n" + table);
}

/// "80$ = 0.8 mm, 55$ = 55000 rpm, 12$ = 1.2 m/min, 99$ = 9.9 m/min, 30$ = 3000 strokes, 1000$ = 1
/// s"; every tool of another diameter here.
TEST(ToolTable1000, HasSixValuesOfFifteenTools) {
  std::string table = "$";
  for (int number = 1; number <= 15; ++number) {
    table += std::to_string(number * 10) + "$55$12$99$30$1000$";
  }
  ASSERT_EQ(std::count(table.begin(), table.end(), '$'), 91);
  const Reading reading = read_1000(table + "\n");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  EXPECT_EQ(reading.body, "X1000Y1000T1\n");
  ASSERT_EQ(reading.layout.tools.size(), 15U);
  for (int number = 1; number <= 15; ++number) {
    const Tool& tool = reading.tool(number);
    ASSERT_TRUE(tool.diameter && tool.infeed && tool.retract);
    EXPECT_DOUBLE_EQ(tool.diameter->in_mm(), number / 10.0);
    EXPECT_EQ(tool.number, number);
    EXPECT_EQ(tool.speed, rpm(55000));
    EXPECT_NEAR(tool.infeed->in_mm_s(), 1.2 * kMmPerSOfOneMPerMin, 1e-9);
    EXPECT_NEAR(tool.retract->in_mm_s(), 9.9 * kMmPerSOfOneMPerMin, 1e-9);
    EXPECT_EQ(tool.max_hits, 3000);
    EXPECT_FALSE(tool.depth_offset);
    EXPECT_EQ(tool.dwell, seconds(1));
    EXPECT_EQ(reading.layout.tool_lines.at(number), 3);
    // "T1 is in M1, T2 is in M2 etc."
    EXPECT_THAT(tool.magazines, ElementsAre(number));
  }
}

/// "If a parameter value is zero, only the $ sign is given out."
TEST(ToolTable1000, AToolWithoutAValueIsNotThere) {
  const Reading reading =
      read_1000("$80$$$$$$" + repeated("$", 12) + "$40$$$$$" + repeated("$", 66));
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  EXPECT_EQ(reading.layout.tools.size(), 2U);
  EXPECT_EQ(reading.tool(1).diameter, mm(0.8));
  EXPECT_FALSE(reading.tool(1).speed);
  EXPECT_EQ(reading.tool(4).speed, rpm(40000));
  EXPECT_FALSE(reading.tool(4).diameter);
}

/// Its six data are zero; "T2 is in M2".
TEST(ToolTable1000, AToolWithoutAValueThatIsTakenIsZero) {
  const Reading reading = read_1000("$80$" + repeated("$", 89));
  const Tool tool = reading.layout.taken_tool(2);
  EXPECT_EQ(tool.number, 2);
  EXPECT_EQ(tool.zeroed, "DSFRNA");
  EXPECT_THAT(tool.magazines, ElementsAre(2));
  EXPECT_EQ(reading.layout.taken_tool(1).diameter, mm(0.8));
  EXPECT_EQ(reading.layout.taken_tool(16), Tool{.number = 16});
}

TEST(ToolTable1000, LineEndsInsideDoNotCount) {
  const Reading reading =
      read_1000("$8\n0$50$\r\n" + repeated("$", 44) + "\n  " + repeated("$", 44) + "\n\n");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  EXPECT_EQ(reading.tool(1).diameter, mm(0.8));
}

/// "The number of all $ given out must always be 91!"
TEST(ToolTable1000, NinetyOneDollarSignsAreNeeded) {
  EXPECT_THAT(read_1000(repeated("$", 91)).diagnostics, IsEmpty());
  expect_layout_refused(read_1000(repeated("$", 90)), "3:1", "89");
  expect_layout_refused(read_1000(repeated("$", 92)), "3:1", "91");
  expect_layout_refused(read_1000("$\n"), "3:1", "0 ");
}

TEST(ToolTable1000, EveryValueIsClosed) {
  expect_layout_refused(read_1000("$80$50"), "3", "\"50\"");
  expect_layout_refused(read_1000(repeated("$", 91) + "\nTHE END"), "3", "\"THE END\"");
}

TEST(ToolTable1000, RefusesBadNumbers) {
  expect_layout_refused(read_1000("$.8$" + repeated("$", 89)), "3:1", "\"D.8\"");
  expect_layout_refused(read_1000("$80$-5$" + repeated("$", 88)), "3:1", "\"S-5\"");
  expect_layout_refused(read_1000("$80$5 5$" + repeated("$", 88)), "3:1", "\"S5 5\"");
}

TEST(ToolTable1000, IsNoTableOfLines) {
  expect_layout_refused(read_1000("$\nT1D80\n$\n"), "3:1", "\"DT1D80\"");
}

}  // namespace
}  // namespace panelcal::sieb_meyer
