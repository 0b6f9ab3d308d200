// SPDX-License-Identifier: Apache-2.0
// Corrections that copies keep for later patterns: G39,SAVE and G39,LOAD as M50, M51 and M52. Run
// on the same panel, source and translation drill the same holes.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/writers/translation/boards.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::same_holes;
using test::sieb_meyer;
using test::translate;
using test::Translation;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr char kOffsets[] = "X0.Y0.M50\nX50.Y0.M50\nX0.Y50.M50\nX100.Y50.M90M30\n";

/// SIEB & MEYER CNC 8x.00 Command Set, G39, Example.
TEST(StoredTranslation, TheManualsExampleOfG39) {
  const std::string text = same_holes(
      sieb_meyer("M31\nG34\nX5.Y5.G32\nX45.Y45.G32\nG31\nG39,SAVE\nG30\n" + std::string(kOffsets) +
                 "M31\nG39,LOAD\nX10.Y20.T1\nX30.Y40.\n" + kOffsets + "G30\nX1.Y1.\n"));
  EXPECT_THAT(text, HasSubstr("M50,1\nM25\nG37\n"));
  EXPECT_THAT(text, HasSubstr("M51,1\nM25\nM52,2\n"));
}

TEST(StoredTranslation, TwoSectionsThatSaveAreTwoLabels) {
  const std::string first =
      "M31\nG34\nX5.Y5.G32\nX45.Y45.G32\nG31\nG39,SAVE\n" + std::string(kOffsets);
  const std::string second =
      "M31\nG34\nX5.Y45.G32\nX45.Y5.G32\nX5.Y5.G32\nG31\nG39,SAVE\n" + std::string(kOffsets);
  const std::string use = "M31\nG39,LOAD\nX10.Y20.T1\nX30.Y40.\n" + std::string(kOffsets);
  const std::string text = same_holes(sieb_meyer(first + use + second + use));
  EXPECT_THAT(text, HasSubstr("M51,2\nM25\nM52,3\n"));
}

/// What a translation to Excellon has no form for.
std::vector<std::string> refusals_of(const std::string& body) {
  const Translation lost = translate(sieb_meyer(body), Dialect::Excellon);
  EXPECT_THAT(lost.errors, IsEmpty());
  EXPECT_TRUE(lost.is_refused);
  return lost.losses;
}

/// M51 wants all of M50's, so that the copies that are left are written out.
TEST(StoredTranslation, BoardsMayBeLeftOut) {
  const std::string save =
      "M31\nG34\nX5.Y5.G32\nX45.Y45.G32\nG31\nG39,SAVE\n" + std::string(kOffsets);
  const std::string load = "M31\nG39,LOAD\nX1.Y1.T1\n";
  EXPECT_THAT(same_holes(sieb_meyer(save + load + "X0.Y0.M50M30\n")),
              HasSubstr("M51,1\nM52,2\nT1\nX1.0Y1.0\nM52,6\nM30\n"));
  same_holes(sieb_meyer(save + load + "X0.Y0.M50\nX50.Y0.M50M30\n"));
  same_holes(sieb_meyer(save + load + kOffsets));
}

/// The control fits them with those of one copy.
TEST(StoredTranslation, RefusesTargetsThatOneCopyWouldTake) {
  const std::string two = "X5.Y5.G32\nX45.Y5.G32\nG31\n";
  for (const std::string save : {"G39,SAVE\n", "X7.Y7.T1\n"}) {
    EXPECT_THAT(refusals_of("X5.Y45.G32\nM31\n" + two + save + kOffsets),
                testing::Contains(test::Reports("p:6: error[translation-refused]",
                                                "a fit with targets from ahead of its section")));
    EXPECT_THAT(refusals_of("M31\n" + two + save + "X5.Y45.G32\n" + kOffsets + "G34\n"),
                testing::Contains(test::Reports("p:11: error[translation-refused]",
                                                "leaves targets to its next copy")));
  }
  same_holes(sieb_meyer("X5.Y45.G32\nM31\n" + two + "X7.Y7.T1\nX0.Y0.M50M30\n"));
}

/// SIEB & MEYER CNC 8x.00 Command Set, G34, and G30: a second one running.
TEST(StoredTranslation, TargetsThatWaitAreCleared) {
  const std::string three = "X5.Y5.G32\nX45.Y5.G32\nX5.Y45.G32\nG31\n";
  for (const std::string clear : {"G34\n", "G30\nG30\n"}) {
    const std::string text =
        same_holes(sieb_meyer("X150.Y150.G32\n" + clear + three + "X9.Y9.T1\n"));
    EXPECT_THAT(text, HasSubstr("$uvis,alg,0,3\n"));
  }
  const std::string text =
      same_holes(sieb_meyer("X150.Y150.G32\nM31\nG34\n" + three + "G39,SAVE\n" + kOffsets +
                            "M31\nG39,LOAD\nX9.Y9.T1\n" + kOffsets));
  EXPECT_THAT(text, HasSubstr("M51,1\nM25\nM52,3\n"));
}

/// An offset under CAMA holds until the end of the copy that it was measured in.
TEST(StoredTranslation, AnOffsetOfTheProgramHoldsInSections) {
  const std::string section = "M31\nX2.Y2.\nX0.Y0.M50\nX50.Y0.M50M30\n";
  const std::string outside = "M49,CAMA\nX5.Y5.G36\nX1.Y1.T1\n";
  same_holes(sieb_meyer(outside + section + "X3.Y3.\nG34\nX4.Y4.\n"));
  EXPECT_THAT(refusals_of(outside + "M31\nX5.Y6.G36\nX0.Y0.M50\nX50.Y0.M50M30\n"),
              ElementsAre(test::Reports("p:6: error[translation-refused]",
                                        "G36 under an offset from outside")));
}

// --- offsets of copies (G36 under CAMA) that they keep -----------------------------------------

constexpr char kBoard[] = "X0.Y0.G32\nX190.Y0.G32\nX0.Y190.G32\nG31\n";
constexpr char kUseOffset[] = "M31\nG39,LOAD\nX10.Y20.T1\nX0.Y0.M50\nX50.Y0.M50M30\n";
constexpr char kTwoCopies[] = "X0.Y0.M50\nX50.Y0.M50M30\n";

std::string in_cama(const std::string& body) {
  return "M49,CAMA\n" + std::string(kBoard) + body;
}

/// The offset alone, on top of the correction that is in force round the section.
TEST(StoredTranslation, AnOffsetOfEachCopyIsStoredAlone) {
  const std::string text =
      same_holes(sieb_meyer(in_cama(std::string("M31\nX5.Y5.G36\nG39,SAVE\nX7.Y7.T1\n") +
                                    kTwoCopies + kUseOffset + "X60.Y30.\nG34\nX1.Y1.\n")),
                 test::kSameFit_um);
  EXPECT_THAT(text, HasSubstr("M50,1\nM25\nG45X5.0Y5.0\nT1\nX7.0Y7.0\nG47\nM01\n"));
  EXPECT_THAT(text, HasSubstr("M51,1\nM25\nM52,1\nX10.0Y20.0\nG47\nM01\n"));
}

/// What panelcal has written itself.
TEST(StoredTranslation, OffsetsOfCopiesLeadThereAndBack) {
  const std::string end = "M01\nM02X50.\nM08\n";
  for (const std::string board : {"", "G36X0.Y0.\nG36X190.Y0.\nG36X0.Y190.\n"}) {
    const std::string there = same_holes(
        test::boards_in_excellon(board + "T1\nM50,1\nM25\nG45X5.Y5.\nX7.Y7.\nG47\n" + end +
                                 "M51,1\nM25\nM52\nX10.Y20.\nG47\n" + end + "G37\nX1.Y1.\n"));
    EXPECT_THAT(there, HasSubstr("M49,CAMA\nX5.Y5.G36\nG39,SAVE\n"));
    const std::string back = same_holes(there, test::kSameFit_um);
    EXPECT_THAT(back, HasSubstr("M52,1\n"));
  }
}

/// Both orders mean the location of the copy's number, so that the second takes it.
TEST(StoredTranslation, ASecondSaveAddsTheOffset) {
  const std::string text = same_holes(
      sieb_meyer("M49,CAMA\nM31\nG34\nX5.Y5.G32\nX45.Y5.G32\nX5.Y45.G32\nG31\nG39,SAVE\nX8.Y8.T1\n"
                 "X25.Y25.G36\nX9.Y9.\nG39,SAVE\n" +
                 std::string(kTwoCopies) + kUseOffset + "X1.Y1.\n"),
      test::kSameFit_um);
  EXPECT_THAT(text, HasSubstr("X8.0Y8.0\nG45X25.0Y25.0\nX9.0Y9.0\nG47\nM01\n"));
  EXPECT_THAT(text, HasSubstr("M51,1\nM25\nM52,4\nX10.0Y20.0\nG47\n"));
}

/// M52 could not leave it out: "as many M52 commands after an M51 as G36/G46" (CNC-7 manual).
TEST(StoredTranslation, RefusesAnOffsetBehindTheSaveOfItsCopy) {
  const std::string begin =
      "M49,CAMA\nM31\nG34\nX5.Y5.G32\nX45.Y5.G32\nX5.Y45.G32\nG31\nG39,SAVE\n";
  const std::string offset = "X25.Y25.G36\nX9.Y9.T1\n";
  EXPECT_THAT(refusals_of(begin + offset + kTwoCopies + kUseOffset),
              ElementsAre(test::Reports("p:10: error[translation-refused]",
                                        "G36 behind G39,SAVE of its section")));
  // The remedies.
  same_holes(sieb_meyer(begin + offset + "G39,SAVE\n" + kTwoCopies + kUseOffset));
  same_holes(sieb_meyer(begin + kTwoCopies + "M31\nG39,LOAD\n" + offset + kTwoCopies + kUseOffset),
             test::kSameFit_um);
}

/// G39,LOAD brings back the correction that an offset stands on, M52 the offset alone.
TEST(StoredTranslation, RefusesOffsetsOnAnotherCorrection) {
  const std::string save = std::string("M31\nX5.Y5.G36\nG39,SAVE\n") + kTwoCopies;
  const std::string again = "X10.Y10.G32\nX180.Y10.G32\nX10.Y180.G32\nG31\nX2.Y2.T1\n";
  for (const std::string& between : {again, std::string("G30\n"), std::string("G34\n")}) {
    EXPECT_THAT(refusals_of(in_cama(save + between + kUseOffset)),
                testing::Contains(HasSubstr("under the correction that it was measured under")));
  }
  same_holes(sieb_meyer(in_cama("G39,SAVE7\n" + save + again + "G39,LOAD7\n" + kUseOffset)),
             test::kSameFit_um);
  EXPECT_THAT(refusals_of(in_cama(std::string("M31\nX5.Y5.G36\nG39,SAVE\nX7.Y7.T1\nG34\n") +
                                  kTwoCopies + "X1.Y1.\n")),
              testing::Contains(HasSubstr("whose section changes the correction")));
}

}  // namespace
}  // namespace panelcal
