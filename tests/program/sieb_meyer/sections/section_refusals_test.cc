// SPDX-License-Identifier: Apache-2.0
// Refusals of scan_sections, with the line where it stands.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/sections/section_scan.h"

namespace panelcal::sieb_meyer {
namespace {

using testing::IsEmpty;

TEST(SectionRefusals, UnbalancedBrackets) {
  expect_refused("X1.Y1.\nX2.M31\nX3.Y3.\n", "2:1 section-unbalanced");
  expect_refused("X1.M31\nX2.M31\nXYM50M30\n", "1:1 section-unbalanced");
  expect_refused("X1.Y1.\nX2.M30\n", "2:1 section-unbalanced");
  expect_refused("X1.M31\nXYM50M30M30\n", "2:1 section-unbalanced");
  expect_refused("X1.Y1.\nX9.M50M30\n", "2:1 section-unbalanced");
}

/// "The maximum admissible number of program sections is 6 (nesting)."
TEST(SectionRefusals, SevenLevels) {
  const auto nested = [](int n) {
    std::string text;
    for (int i = 0; i < n; ++i) text += "X1.Y1.M31\n";
    for (int i = 0; i < n; ++i) text += "XYM50M30\n";
    return text;
  };
  EXPECT_EQ(sound(nested(6)).tree.sections.size(), 6U);
  expect_refused(nested(7), "7:1 nesting-too-deep", "6");
  expect_refused("X1.M31M31M31M31M31M31M31\n", "1:1 nesting-too-deep", "6");
  // "Calling the subprogram is counted as one nesting depth."
  EXPECT_EQ(sound(nested(4), {.in_subprogram = true, .depth = 2}).tree.sections.size(), 4U);
  expect_refused(nested(5), "5:1 nesting-too-deep", "6", {.in_subprogram = true, .depth = 2});
  expect_refused(nested(1), "1:1 nesting-too-deep", "6", {.in_subprogram = true, .depth = 6});
}

/// "The offset structure must be programmed after every program section": nothing else may stand
/// between the offset lines, for no copy would execute it.
/// 5, table of additional offset possibilities: M60 comes with one of M70, M80 and M90 at most.
TEST(SectionRefusals, CombinationsThatTheManualDoesNotHave) {
  for (const char* codes : {"M50M70", "M60M50", "M70M80", "M80M90", "M60M70M80"}) {
    expect_refused("X2.Y1.M31\nX1.Y1." + std::string(codes) + "M30\n", "2:1 argument-invalid");
  }
}

TEST(SectionRefusals, ABracketClosedAndOpenedInOneLine) {
  expect_refused("X1.Y1.M31\nX2.Y2.M30M31\nX1.M50M30\n", "2:1 section-mixed");
}

/// Behind the first offset line nothing runs, so a damaged line there would vanish.
TEST(SectionRefusals, DamagedLinesAmongTheOffsets) {
  expect_refused("X1.Y1.M31\nX0Y0M50\nX10.Y0,M50\nX20.Y0M50M30\n", "3:7 block-syntax", ",");
  expect_refused("X1.Y1.M31\nX0Y0M50\nx10.Y0M50\nX20.Y0M50M30\n", "3:1 block-syntax", "x");
}

TEST(SectionRefusals, OtherLinesAmongTheOffsets) {
  for (const std::string line : {"X2.Y2.",
                                 "  X2.Y2.",
                                 "X2.Y2.T2",
                                 "X2.M31M30",
                                 "M99,A",
                                 "T2",
                                 "G82",
                                 "F1.2",
                                 "Z3.",
                                 "M47,TURN",
                                 "M49,FV1",
                                 "/X2.Y2."}) {
    expect_refused("X1.M31\nX10.M50\n" + line + "\nX20.M50M30\n", "3:1 section-mixed", "M31");
    expect_refused("X1.M31\nXYM50V2\n" + line + "\nX20.M50W3M30\n", "3:1 section-mixed", "M31");
  }
  sound("X1.M31\nX10.M50\n(COMMENT X)\n\n \t\nX20.M50\nM30\n");
  sound("X1.M31\nX10.M50\n/X2.Y2.\nX20.M50M30\n", {.deletes_blocks = true});
}

TEST(SectionRefusals, OffsetsThatMoveNothing) {
  expect_refused("T2\nX10.M50\n", "2:1 section-mixed");
  expect_refused("X1.Y1.T1\nX10.M50\nT2\nX20.M50\n", "4:1 section-mixed");
}

TEST(SectionRefusals, OtherWordsInAnOffsetLine) {
  const auto refuses = [](const std::string& line, int column, const std::string& word) {
    expect_refused("X1.Y1.M31\n" + line + "\nXYM50M30\n",
                   "2:" + std::to_string(column) + " argument-invalid",
                   "\"" + word + "\" in \"" + line + "\"");
  };
  refuses("X1.Y1.T2M50", 7, "T2");
  refuses("X1.Y1.M50R5.", 10, "R5.");
  refuses("X1.Y1.M50V1", 10, "V1");
  refuses("X1.Y1.M50V", 10, "V");
  refuses("X1.Y1.M50M77", 10, "M77");
  refuses("X1.Y1.M50M31M30", 10, "M31");
}

TEST(SectionRefusals, BadNumbersInAnOffsetLine) {
  expect_refused("X1.M31\nX1.2.3M50M30\n", "2:1 number-malformed", "\"X1.2.3\"");
  expect_refused("X1.M31\nX1.Y-M50M30\n", "2:4 number-malformed", "\"Y-\"");
  expect_refused("X100T1\nX1.M50\n", "2:1 number-malformed", {.format = FileFormat::F1000});
}

/// The line reports its own fault when it is executed.
TEST(SectionRefusals, LinesThatCannotBeReadAreLeftToOthers) {
  EXPECT_THAT(scan("X1.M31\nX2.Y2.T1=\nXYM50M30\n").diagnostics, IsEmpty());
}

/// A later error may only be a consequence.
TEST(SectionRefusals, OnlyTheFirstErrorIsReported) {
  EXPECT_EQ(scan("X1.M30\nX1.M31\nX2.M31\n").diagnostics.size(), 1U);
}

}  // namespace
}  // namespace panelcal::sieb_meyer
