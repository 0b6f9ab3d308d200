// SPDX-License-Identifier: Apache-2.0
// Sections whose second copy begins in another state than the first, which are no patterns; turned
// copies that are written out; holes that a copy leaves out.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/writers/translation/boards.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::boards_in_excellon;
using test::FunctionSource;
using test::Reports;
using test::run_on;
using test::same_strokes;
using test::sieb_meyer;
using test::small_boards;
using test::translate;
using test::Translation;
using test::WorkRun;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr char kTwoCopies[] = "X0.Y0.M50\nX50.Y0.M50M30\n";

std::string section(const std::string& body) {
  return "M31\n" + body + kTwoCopies;
}

// --- holes that an area leaves out -------------------------------------------------------------

TEST(TranslatedCopies, AForbiddenAreaLeavesOutItsTargetHole) {
  const std::string text =
      sieb_meyer("X1.Y1.T1\nX30.Y20.M58D30.\nX30.Y20.G36\nX31.Y20.\nX80.Y20.G36\nX100.Y1.\n");
  EXPECT_THAT(same_strokes(text, Dialect::Excellon),
              HasSubstr("X1.0Y1.0\nG34,1\nG38X80.0Y20.0\nX100.0Y1.0\n"));
  EXPECT_THAT(same_strokes(text, Dialect::SiebMeyer), HasSubstr("\nX80.Y20.G36\nX100.Y1."));
  EXPECT_THAT(same_strokes(text, Dialect::SiebMeyer), Not(HasSubstr("X30.Y20.G36")));
}

// --- what the second copy begins with ----------------------------------------------------------

TEST(TranslatedCopies, TargetHolesHaveTheDepthOfTheirCopy) {
  for (const std::string& text : {"X1.Y1.T1Z1.\n" + section("X5.Y5.G36\nX7.Y7.Z2.\n"),
                                  "X1.Y1.T1G83K.2\n" + section("X5.Y5.G36\nX7.Y7.K.3\n"),
                                  "X1.Y1.T1G83K.2\n" + section("X2.Y2.G36\nX7.Y7.G82Z1.\n"),
                                  "X1.Y1.T1Z1.\n" + section("X2.Y2.G36\nX7.Y7.G83K.2\n"),
                                  "X1.Y1.T1\n" + section("X2.Y2.G36\nX7.Y7.T2\n")}) {
    EXPECT_THAT(same_strokes(sieb_meyer(text + "X9.Y9.\n"), Dialect::SiebMeyer),
                Not(HasSubstr("M31")));
  }
  // A pattern's target needs neither tool nor depth.
  EXPECT_THAT(same_strokes(sieb_meyer("M49,CAMA\n" + section("X5.Y5.G36\nX7.Y7.T1Z1.\n")),
                           Dialect::SiebMeyer),
              HasSubstr("M31"));
}

TEST(TranslatedCopies, ModesThatChangeBehindTheirUseAreNoPatterns) {
  for (const std::string& text :
       {"M49,NIB.1\n" + section("X5.Y5.G84R4.\nM49,NIB.2\nX27.Y7.G84R4.\n"),
        section("X5.Y5.G84R4.\nM49,NIBO\nX27.Y7.G84R4.\n"),
        "M49,OPID,A\n" + section("X5.Y5.M97,*\nM49,OPID,B\nX5.Y27.M97,*\n"),
        section("/X5.Y5.\nM49,BLKD\nX7.Y7.\n"),
        "M49,BLKD\n" + section("/X5.Y5.\nM49,NOBLKD\nX7.Y7.\n"),
        section("/X5.Y5.T1\nX7.Y7.T2\nM49,BLKD\nX8.Y8.\n"),
        section("X30.Y30.T2T0\nX30.Y30.G46R8.F1.\nX30.Y30.T0\nM49,ROUT,A\nX5.Y5.T1\n")}) {
    const std::string whole = sieb_meyer("T1\n" + text + "X1.Y1.T1\n");
    EXPECT_THAT(same_strokes(whole, Dialect::SiebMeyer), Not(HasSubstr("M31")));
    EXPECT_THAT(same_strokes(whole, Dialect::Excellon), Not(HasSubstr("M25")));
  }
  // Each copy states the mode before it uses it, or does not use it, or leaves it as it was.
  for (const std::string& text : {section("M49,NIB.1\nX5.Y5.G84R4.\nM49,NIB.2\nX27.Y7.G84R4.\n"),
                                  section("X5.Y5.\nM49,BLKD\nX7.Y7.\n"),
                                  section("/X5.Y5.\nM49,BLKD\n/X7.Y7.\nM49,NOBLKD\nX8.Y8.\n")}) {
    const std::string whole = sieb_meyer("T1\n" + text + "X1.Y1.T1\n");
    EXPECT_THAT(same_strokes(whole, Dialect::SiebMeyer), HasSubstr("M31"));
    EXPECT_THAT(same_strokes(whole, Dialect::Excellon), HasSubstr("M25"));
  }
}

TEST(TranslatedCopies, ALineThatIsLeftOutStatesNothing) {
  const std::string text =
      sieb_meyer("M49,BLKD\nT1\n" + section("/X3.Y3.T1\nX5.Y5.\nX7.Y7.T2\n") + "X1.Y1.T1\n");
  EXPECT_THAT(same_strokes(text, Dialect::SiebMeyer), Not(HasSubstr("M31")));
  EXPECT_THAT(same_strokes(text, Dialect::Excellon), Not(HasSubstr("M25")));
}

/// Nothing would end the offset of a copy that is written out (G45 of Excellon has G47).
TEST(TranslatedCopies, APatternModeThatChangesBehindItsUse) {
  const std::string into_cama =
      "T1\nM49,NOCAMA\n" + section("X5.Y5.T1G36\nX7.Y7.\nM49,CAMA\nX25.Y25.G36\nX8.Y8.\n");
  // The second copy aligns itself at both targets.
  EXPECT_THAT(translate(sieb_meyer(into_cama + "X1.Y1.\n"), Dialect::Excellon).losses,
              ElementsAre(Reports("p:8: error[translation-refused]", "several targets (CAMA)")));
  EXPECT_THAT(translate(sieb_meyer(into_cama + "X1.Y1.\n"), Dialect::SiebMeyer).losses,
              testing::Contains(Reports("p:8: error[translation-refused]", "\"G36\"")));
  const std::string out_of_cama =
      "T1\nM49,CAMA\n" + section("X25.Y25.G36\nX8.Y8.\nM49,NOCAMA\nX7.Y7.G36\nX9.Y9.\n");
  same_strokes(sieb_meyer(out_of_cama + "X1.Y1.\n"), Dialect::Excellon);
  // Stated ahead of the first G36 of each copy, the mode is the pattern's own.
  EXPECT_THAT(same_strokes(
                  sieb_meyer("T1\n" + section("X1.Y1.\nM49,CAMA\nX25.Y25.G36\nX8.Y8.\n") + "G34\n"),
                  Dialect::SiebMeyer),
              HasSubstr("M31\nX1.Y1.\nM49,CAMA\nX25.Y25.G36\nX8.Y8.\n"));
}

TEST(TranslatedCopies, TheSizeOfASeriesMayChangeInAPattern) {
  const std::string targets = "G36X5.Y5.\nG36X45.Y45.\nG36X5.Y45.\nG36X45.Y5.\n";
  const std::string end = "M01\nM02X50.\nM08\nX1.Y1.\n";
  EXPECT_THAT(same_strokes(boards_in_excellon("T1\n$uvis,alg,0,4\nM25\n" + targets +
                                              "X7.Y7.\n$uvis,alg,0,2\nX8.Y8.\n" + end),
                           Dialect::SiebMeyer),
              Not(HasSubstr("M31")));
  EXPECT_THAT(same_strokes(boards_in_excellon("T1\nM25\n$uvis,alg,0,4\n" + targets +
                                              "X7.Y7.\n$uvis,alg,0,2\nX8.Y8.\n" + end),
                           Dialect::SiebMeyer),
              HasSubstr("M31"));
}

// --- slots (mode 5) ----------------------------------------------------------------------------

TEST(TranslatedCopies, ASlotInATurnedCopyShowsTheOtherCoordinate) {
  WalkOptions slots;
  slots.sieb_meyer.measurement_mode = 5;
  const std::string series = "G34\nX5.Y5.G33\nX25.Y5.G32\nX5.Y45.G33\nX45.Y25.G32\nG31\nX10.Y20.\n";
  for (const std::string offset : {"M60", "M60M70", "M60M80", "M60M90", "M70", "M80", "M90"}) {
    // The second copy begins with another tool.
    const std::string text = sieb_meyer(
        "X1.Y1.T1\nM31\n" + series + "X11.Y21.T2\nX0.Y0.M50\nX100.Y50." + offset + "M30\nX9.Y9.\n");
    same_strokes(text, Dialect::SiebMeyer, slots);
  }
  const std::string turned = sieb_meyer("M49,RA90.\nT1\n" + series + "X11.Y21.\n");
  EXPECT_THAT(same_strokes(turned, Dialect::SiebMeyer, slots),
              HasSubstr("X-5.Y5.G32\nX-5.Y25.G33\n"));
  FunctionSource panel = small_boards();
  const WorkRun before = run_on(panel, turned, slots);
  const WorkRun after = run_on(panel, translate(turned, Dialect::SiebMeyer, slots).text, slots);
  ASSERT_EQ(before.requests.size(), 4U);
  ASSERT_EQ(after.requests.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(before.requests[i].axes, after.requests[i].axes);
  // As a pattern the section keeps its letters.
  EXPECT_THAT(same_strokes(sieb_meyer("X1.Y1.T1\nM31\n" + series + "X0.Y0.M50\nX100.Y50.M60M30\n"),
                           Dialect::SiebMeyer,
                           slots),
              HasSubstr("X5.Y5.G33\nX25.Y5.G32\n"));
}

}  // namespace
}  // namespace panelcal
