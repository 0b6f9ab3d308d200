// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/sections/sections.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/sections/section_scan.h"
#include "tests/support/matchers.h"

namespace panelcal::sieb_meyer {
namespace {

using Eigen::Vector2d;
using test::IsNearMatrix;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr double kExact_mm = 1e-12;

// --- brackets ------------------------------------------------------------------------------------

TEST(Sections, ATextWithoutBracketsHasNone) {
  for (const char* const text :
       {"", "X1.Y1.T1\nX2.Y2.\n", "X1.Y1.T1\nM47,TURN\nM20\n", "(M31)\n"}) {
    EXPECT_THAT(sound(text).tree.sections, IsEmpty()) << text;
    EXPECT_THAT(sound(text).tree.roots, IsEmpty()) << text;
  }
}

TEST(Sections, BeginWithTheLineOfTheBracketAndEndBehindTheOther) {
  const Scan out = sound("X1.Y1.T1\nX2.Y2.M31\nX3.Y3.\nX10.Y20.M50\nX30.M50M30\nX4.Y4.\n");
  ASSERT_EQ(out.tree.sections.size(), 1U);
  EXPECT_THAT(out.tree.roots, ElementsAre(0));
  EXPECT_EQ(out[0].parent, -1);
  EXPECT_TRUE(out[0].is_bracketed);
  EXPECT_TRUE(out[0].is_offset());
  EXPECT_EQ(out[0].begin.number, 2);
  EXPECT_EQ(out.body(0), "X2.Y2.M31\nX3.Y3.\n");
  EXPECT_EQ(out[0].closing.number, 5);
  EXPECT_EQ(out[0].after.number, 6);
  EXPECT_EQ(out.text.substr(out[0].after.offset), "X4.Y4.\n");
}

/// "The coordinates already belong to the bracketed section", of M30 too; without an offset line it
/// is executed once.
TEST(Sections, WithoutOffsetsTheClosingLineBelongsToThem) {
  const Scan out = sound("X1.Y1.M31\nX2.Y2.M30\nX3.Y3.\n");
  ASSERT_EQ(out.tree.sections.size(), 1U);
  EXPECT_FALSE(out[0].is_offset());
  EXPECT_EQ(out[0].n_copies(), 0);
  EXPECT_EQ(out.body(0), "X1.Y1.M31\nX2.Y2.M30\n");
  EXPECT_EQ(out[0].after.number, 3);
}

TEST(Sections, MayBeALineLong) {
  const Scan out = sound("X1.Y1.M31M30\n");
  ASSERT_EQ(out.tree.sections.size(), 1U);
  EXPECT_EQ(out.body(0), "X1.Y1.M31M30\n");
}

/// The example of M31: one section for each tool inside that of the final offset.
TEST(Sections, AreNested) {
  const Scan out = sound(
      "X10.Y30.T1 M31 M31\nX30.Y40.M50\nX70.Y20.M50 M30\nX10.Y30.T2 M31\nX30.Y40.M50\n"
      "X70.Y20.M50 M30\n(FINAL OFFSET)\nX123.45Y234.67M50 M30\n");
  ASSERT_EQ(out.tree.sections.size(), 3U);
  EXPECT_THAT(out.tree.roots, ElementsAre(0));
  EXPECT_THAT(out[0].children, ElementsAre(1, 2));
  EXPECT_EQ(out[1].parent, 0);
  EXPECT_EQ(out[2].parent, 0);
  EXPECT_THAT(out[1].children, IsEmpty());
  EXPECT_EQ(out.body(1), "X10.Y30.T1 M31 M31\n");
  EXPECT_EQ(out.body(2), "X10.Y30.T2 M31\n");
  EXPECT_EQ(out[0].begin.number, 1);
  EXPECT_EQ(out[0].closing.number, 8);
  EXPECT_EQ(out.body(0), out.text.substr(0, out.text.find("X123")));
  EXPECT_EQ(out[0].n_copies(), 1);
  EXPECT_EQ(out[1].n_copies(), 2);
  EXPECT_THAT(out[0].rows[0].first_mm, IsNearMatrix(Vector2d(123.45, 234.67), kExact_mm));
}

/// "The M30 command terminates the section that has been introduced by the last M31 command"; those
/// of one line nest in one another.
TEST(Sections, SeveralBracketsInALineNest) {
  const Scan out = sound("X1.Y1.M31M31M31\nX5.YM50M30\nXY5.M50M30M30\nX9.Y9.\n");
  ASSERT_EQ(out.tree.sections.size(), 3U);
  EXPECT_EQ(out[1].parent, 0);
  EXPECT_EQ(out[2].parent, 1);
  EXPECT_EQ(out[2].closing.number, 2);
  EXPECT_EQ(out[1].closing.number, 3);
  EXPECT_EQ(out[0].closing.number, 3);
  EXPECT_TRUE(out[2].is_offset());
  EXPECT_TRUE(out[1].is_offset());
  EXPECT_FALSE(out[0].is_offset());
  EXPECT_EQ(out.body(1), "X1.Y1.M31M31M31\nX5.YM50M30\n");
  EXPECT_EQ(out[0].after.number, 4);
}

TEST(Sections, FollowOneAnother) {
  const Scan out = sound("X1.Y1.M31\nXYM50M30\nX2.Y2.\nX3.Y3.M31\nXYM50M30\n");
  EXPECT_THAT(out.tree.roots, ElementsAre(0, 1));
  EXPECT_EQ(out[1].begin.number, 4);
}

TEST(Sections, AreScannedBetweenTwoPlaces) {
  const std::string text = "X9.M31\nX1.M31\nXYM50M30\nX9.M30\n";
  DiagnosticLog log;
  const SectionTree tree =
      scan_sections(text, {7, 2}, text.find("X9.M30"), {}, Reporter("p.ss", log));
  EXPECT_FALSE(log.has_errors());
  ASSERT_EQ(tree.sections.size(), 1U);
  EXPECT_EQ(tree.sections[0].begin.number, 2);
  EXPECT_EQ(tree.sections[0].begin.offset, 7U);
  EXPECT_EQ(tree.sections[0].after.number, 4);
}

/// Line ends, comments, blanks and leading zeros change nothing; texts open nothing.
TEST(Sections, AreFoundHoweverTheyAreWritten) {
  const Scan out = sound("  X1. Y1. M31 (M30)\r\nM47,M30\r\n\r\n X Y M50 M30 (END M30)\r\n");
  ASSERT_EQ(out.tree.sections.size(), 1U);
  EXPECT_EQ(out.body(0), "  X1. Y1. M31 (M30)\r\nM47,M30\r\n\r\n");
}

// --- offsets -------------------------------------------------------------------------------------

TEST(OffsetLine, ALetterLeftOutIsZero) {
  const Scan out = sound("X1.Y1.M31\nX5.M50\nY6.M50\nM50\nXYM50M30\n");
  ASSERT_EQ(out[0].rows.size(), 4U);
  EXPECT_EQ(out[0].rows[0].first_mm, Vector2d(5, 0));
  EXPECT_EQ(out[0].rows[1].first_mm, Vector2d(0, 6));
  EXPECT_EQ(out[0].rows[2].first_mm, Vector2d(0, 0));
  EXPECT_EQ(out[0].rows[3].first_mm, Vector2d(0, 0));
  EXPECT_EQ(out[0].rows[3].line, 5);
}

TEST(OffsetLine, IsWrittenInTheFormat) {
  const SectionRules rules = {.format = FileFormat::F1000};
  const Scan out = sound("X1000Y1000T1\nX1234Y-5M50\n", rules);
  EXPECT_THAT(out[0].rows.at(0).first_mm, IsNearMatrix(Vector2d(12.34, -0.05), kExact_mm));
}

/// Place of the corner (2, 1) of a pattern, by the manual's formulas and worked positions for axis
/// version 1: M60 is (-y, x), M60M70 (y, x), M60M80 (-y, -x), M60M90 (y, -x).
TEST(OffsetLine, HasEightOrientations) {
  const struct {
    const char* command;
    Vector2d corner_mm;
  } cases[] = {
      {"M50", {2, 1}},
      {"M70", {-2, 1}},
      {"M80", {2, -1}},
      {"M90", {-2, -1}},
      {"M60", {-1, 2}},
      {"M60M70", {1, 2}},
      {"M60M80", {-1, -2}},
      {"M60M90", {1, -2}},
  };
  for (const auto& [command, corner_mm] : cases) {
    SCOPED_TRACE(command);
    const Scan out = sound("X2.Y1.M31\nX10.Y20." + std::string(command) + "M30\n");
    ASSERT_EQ(out[0].rows.size(), 1U);
    const CopyRow& row = out[0].rows[0];
    EXPECT_EQ(row.first_mm, Vector2d(10, 20));
    EXPECT_EQ(Vector2d(row.orientation * Vector2d(2, 1)), corner_mm);
  }
}

TEST(OffsetLine, OrientationsAreGivenByTurnAndMirrors) {
  EXPECT_EQ(offset_orientation(false, false, false), Eigen::Matrix2d::Identity());
  const auto corner = [](bool turned, bool mirror_x, bool mirror_y) {
    return Vector2d(offset_orientation(turned, mirror_x, mirror_y) * Vector2d(2, 1));
  };
  EXPECT_EQ(corner(false, true, false), Vector2d(-2, 1));
  EXPECT_EQ(corner(false, false, true), Vector2d(2, -1));
  EXPECT_EQ(corner(false, true, true), Vector2d(-2, -1));
  EXPECT_EQ(corner(true, false, false), Vector2d(-1, 2));
  EXPECT_EQ(corner(true, true, false), Vector2d(1, 2));
  EXPECT_EQ(corner(true, false, true), Vector2d(-1, -2));
  EXPECT_EQ(corner(true, true, true), Vector2d(1, -2));
}

// --- M50V2 ---------------------------------------------------------------------------------------

/// The example of M50V2: five patterns from 0 to 440 mm.
TEST(PatternRow, LiesBetweenItsFirstAndLastZeroPoint) {
  const Scan out = sound("X1.Y1.M31\nX0Y0 M50V2\nX440.Y M50W5 M30\n");
  ASSERT_EQ(out[0].rows.size(), 1U);
  const CopyRow& row = out[0].rows[0];
  EXPECT_EQ(row.count, 5);
  EXPECT_EQ(row.line, 3);
  EXPECT_EQ(out[0].n_copies(), 5);
  EXPECT_EQ(row.orientation, Eigen::Matrix2d::Identity());
  for (int i = 0; i < 5; ++i) EXPECT_EQ(row.offset_mm(i), Vector2d(110 * i, 0)) << i;
  EXPECT_EQ(out.body(0), "X1.Y1.M31\n");
}

TEST(PatternRow, EndsExactlyAtTheLastZeroPoint) {
  const Scan out = sound("X1.Y1.M31\nX.1Y.2M50V2\nX10.Y20.3M50W7M30\n");
  EXPECT_EQ(out[0].rows.at(0).offset_mm(0), Vector2d(0.1, 0.2));
  EXPECT_THAT(out[0].rows.at(0).offset_mm(6), IsNearMatrix(Vector2d(10, 20.3), kExact_mm));
  EXPECT_THAT(out[0].rows.at(0).offset_mm(3), IsNearMatrix(Vector2d(5.05, 10.25), kExact_mm));
}

TEST(PatternRow, StandsAmongOtherOffsets) {
  const Scan out =
      sound("X1.Y1.M31\nX5.Y5.M60\nXYM50V2\nX10.YM50W3\nXY10.M50V2\nX10.Y10.M50W3M30\n");
  ASSERT_EQ(out[0].rows.size(), 3U);
  EXPECT_EQ(out[0].rows[0].count, 1);
  EXPECT_EQ(out[0].rows[2].offset_mm(1), Vector2d(5, 10));
  EXPECT_EQ(out[0].n_copies(), 7);
}

TEST(PatternRow, NeedsBothOfItsLines) {
  expect_refused("X1.M31\nXYM50V2\nX9.Y9.M50M30\n", "3:1 argument-invalid", "M50V2");
  expect_refused("X1.M31\nX9.Y9.M50W5M30\n", "2:1 argument-invalid");
  expect_refused("X1.M31\nXYM50V2M30\n", "2:1 argument-invalid");
  expect_refused("X1.M31\nXYM50V2\nXYM50V2\nX9.M50W5M30\n", "2:1 argument-invalid");
  expect_refused("X1.T1\nXYM50V2\n", "2:1 argument-invalid");
  expect_refused("X1.M31\nXYM50V2W5\nX9.M50W5M30\n", "2:1 argument-invalid", "M50V2");
}

TEST(PatternRow, IsNotTurned) {
  expect_refused("X1.M31\nXYM60V2\nX9.M50W5M30\n", "2:1 argument-invalid");
  expect_refused("X1.M31\nXYM50V2\nX9.M70W5M30\n", "3:1 argument-invalid");
}

TEST(PatternRow, HasTwoPatternsAtLeast) {
  for (const char* const count : {"W1", "W0", "W", "W-2", "W2.5"}) {
    expect_refused("X1.M31\nXYM50V2\nX9.M50" + std::string(count) + "M30\n",
                   "3:7 argument-invalid",
                   "\"" + std::string(count) + "\" in \"X9.M50");
  }
  EXPECT_EQ(sound("X1.M31\nXYM50V2\nX9.M50W2M30\n")[0].n_copies(), 2);
}

/// "- * *" at the head of the section M50V2.
TEST(PatternRow, IsNoneOfFormat1000) {
  expect_refused("X100Y100T1\nXYM50V2\nX900YM50W3M30\n",
                 "2:6 command-format",
                 "\"V2\"",
                 {.format = FileFormat::F1000});
  EXPECT_EQ(sound("X1.M31\nXYM50V2\nX9.M50W3M30\n", {.format = FileFormat::F3000})[0].n_copies(),
            3);
}

// --- without brackets ----------------------------------------------------------------------------

TEST(ImplicitSection, IsAllSinceTheLastOffsets) {
  const Scan out = sound("X1.Y1.T1\nX2.Y2.\nX10.YM50\nX20.YM50\nX3.Y3.T2\nXY10.M70\nX4.Y4.\n");
  ASSERT_EQ(out.tree.sections.size(), 2U);
  EXPECT_THAT(out.tree.roots, ElementsAre(0, 1));
  EXPECT_EQ(out.body(0), "X1.Y1.T1\nX2.Y2.\n");
  EXPECT_EQ(out[0].n_copies(), 2);
  EXPECT_FALSE(out[0].is_bracketed);
  EXPECT_EQ(out[0].closing.number, 4);
  EXPECT_EQ(out[0].after.number, 5);
  EXPECT_EQ(out.body(1), "X3.Y3.T2\n");
  EXPECT_EQ(out[1].n_copies(), 1);
  EXPECT_EQ(out.text.substr(out[1].after.offset), "X4.Y4.\n");
}

/// Format 1000 has M30 and no M31.
TEST(ImplicitSection, EndsAtM30InFormat1000) {
  const SectionRules rules = {.format = FileFormat::F1000};
  const Scan out =
      sound("X100Y100T1\nX1000YM50M30\nX200Y200\nXYM50\nX1000YM50M30\nX300Y300\n", rules);
  ASSERT_EQ(out.tree.sections.size(), 2U);
  EXPECT_EQ(out.body(0), "X100Y100T1\n");
  EXPECT_EQ(out.body(1), "X200Y200\n");
  EXPECT_EQ(out[1].n_copies(), 2);
  expect_refused("X100Y100T1\nX200Y200M30\n", "2:1 section-unbalanced", rules);
}

TEST(ImplicitSection, ALineWithALeadingBlankBeginsTheNextOne) {
  const Scan out = sound("X1.Y1.T1\nX10.YM50\n  X2.Y2.\nX20.YM50\n");
  ASSERT_EQ(out.tree.sections.size(), 2U);
  EXPECT_EQ(out.body(1), "  X2.Y2.\n");
}

TEST(ImplicitSection, CommentsBetweenOffsetsChangeNothing) {
  const Scan out = sound("X1.Y1.T1\nX10.YM50\n(X AND Y)\n\nX20.YM50\n");
  ASSERT_EQ(out.tree.sections.size(), 1U);
  EXPECT_EQ(out[0].n_copies(), 2);
}

TEST(ImplicitSection, IsNoneInsideOrBehindBrackets) {
  expect_refused("X1.M31\nXYM50M30\nX2.Y2.\nX9.M50\n", "4:1 section-mixed");
  expect_refused("X1.M31M30\nX9.M50\n", "2:1 section-mixed");
}

TEST(ImplicitSection, IsNoneInASubprogram) {
  const SectionRules rules = {.in_subprogram = true, .depth = 1};
  expect_refused("X1.Y1.\nX9.M50\n", "2:1 section-mixed", rules);
  EXPECT_EQ(sound("X1.Y1.M31\nX9.M50M30\n", rules).tree.sections.size(), 1U);
}

// --- what is inside ------------------------------------------------------------------------------

TEST(SectionContents, AreKnownOfAllInnerSections) {
  const Scan out = sound(
      "X1.M31M31\nX1.Y1.D5.M58\nXYM50M30\nX2.M31\nX1.Y1.G32\nXYM50M30\nXYM50M30\n"
      "X3.M31\nXYM50M30\n");
  ASSERT_EQ(out.tree.sections.size(), 4U);
  EXPECT_TRUE(out[0].has.own_copies && out[0].has.measurements);
  EXPECT_TRUE(out[1].has.own_copies && !out[1].has.measurements);
  EXPECT_TRUE(!out[2].has.own_copies && out[2].has.measurements);
  EXPECT_FALSE(out[3].has.own_copies || out[3].has.measurements);
  EXPECT_FALSE(out[0].has.calls);
}

TEST(SectionContents, CallsMayMeasure) {
  const Scan out = sound("X1.M31\nXYM99,A\nXYM50M30\n");
  EXPECT_TRUE(out[0].has.calls && out[0].has.measurements);
}

TEST(SectionContents, CameraAndProbeMeasure) {
  for (const char* const line : {"G31", "G36", "G39,SAVE", "M75,A", "G71K.4", "X1.G73", "X1.G79"}) {
    EXPECT_TRUE(sound("X1.M31\n" + std::string(line) + "\nXYM50M30\n")[0].has.measurements) << line;
  }
  EXPECT_FALSE(sound("X1.M31\nG83K1.\nM21\nXYM50M30\n")[0].has.measurements);
}

/// &R is the number of the copy; a forbidden area is reported for each.
TEST(SectionContents, CopiesMayDifferFromOneAnother) {
  const auto own_copies = [](const std::string& line) {
    return sound("X1.M31\n" + line + "\nXYM50M30\n")[0].has.own_copies;
  };
  EXPECT_TRUE(own_copies("X1.Y1.M97,A-&R"));
  EXPECT_TRUE(own_copies("X1.Y1.M98,&R"));
  EXPECT_TRUE(own_copies("X1.Y1.D5.M58"));
  EXPECT_FALSE(own_copies("X1.Y1.M97,A-&N"));
  EXPECT_FALSE(own_copies("M47,&R"));
}

TEST(SectionContents, OfOneWithoutBracketsAreItsOwn) {
  const Scan out = sound("X1.Y1.G32\nX10.YM50\nX2.Y2.\nX20.YM50\nX3.\nM75,A\nX4.\nX30.YM50\n");
  ASSERT_EQ(out.tree.sections.size(), 3U);
  EXPECT_TRUE(out[0].has.measurements);
  EXPECT_FALSE(out[1].has.measurements);
  EXPECT_TRUE(out[2].has.measurements);
}

/// Text behind the offsets belongs to the next section.
TEST(SectionContents, ALineWithoutCoordinatesBeginsTheNextSectionToo) {
  const Scan out = sound("X1.Y1.\nX10.YM50\nG71K.4\nX2.Y2.\nX20.YM50\n");
  ASSERT_EQ(out.tree.sections.size(), 2U);
  EXPECT_EQ(out.body(1), "G71K.4\nX2.Y2.\n");
  EXPECT_FALSE(out[0].has.measurements);
  EXPECT_TRUE(out[1].has.measurements);
}

// --- block delete --------------------------------------------------------------------------------

TEST(SectionsUnderBlkd, LinesWithASlashAreNotThere) {
  const std::string text = "X1.Y1.M31\n/X2.M31\n/XYM50M30\nX9.M50M30\n";
  EXPECT_EQ(sound(text).tree.sections.size(), 2U);
  const Scan out = sound(text, {.deletes_blocks = true});
  ASSERT_EQ(out.tree.sections.size(), 1U);
  EXPECT_EQ(out[0].n_copies(), 1);
}

TEST(SectionsUnderBlkd, M49TurnsItOnAndOff) {
  const Scan out = sound("/X1.Y1.M31M30\nM49,BLKD\n/X2.Y2.M31M30\nM49,NOBLKD\n/X3.Y3.M31M30\n");
  ASSERT_EQ(out.tree.sections.size(), 2U);
  EXPECT_EQ(out[0].begin.number, 1);
  EXPECT_EQ(out[1].begin.number, 5);
}

TEST(SectionsUnderBlkd, OnlyM49Does) {
  EXPECT_EQ(sound("M47,BLKD\nX1.Y1.M97,BLKD\n/X2.Y2.M31M30\n").tree.sections.size(), 1U);
}

}  // namespace
}  // namespace panelcal::sieb_meyer
