// SPDX-License-Identifier: Apache-2.0
// Corrections that copies keep for later patterns: M50, M51 and M52 as G39,SAVE and G39,LOAD. Run
// on the same panel, source and translation drill the same holes.
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/writers/translation/boards.h"
#include "tests/support/folders.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::kSameOnPanel_um;
using test::panel_of_boards;
using test::same_holes;
using test::translate;
using test::Translation;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string excellon(const std::string& body) {
  return test::boards_in_excellon(body);
}

constexpr char kBoard[] = "G36X0.Y0.\nG36X190.Y0.\nG36X0.Y190.\n";
constexpr char kTargets[] = "G46X5.Y5.\nG46X45.Y5.\nG46X5.Y45.\n";
constexpr char kCopies[] = "M01\nR1M02X50.\nM01\nR2M02Y50.\nM08\n";
constexpr char kUse[] =
    "M51,1\nM25\nM52,3\nX10.Y20.\nX40.Y30.\nM01\nR1M02X50.\nM01\nR2M02Y50.\nM08\n";

TEST(StoredTranslation, ACopysNestedSeriesBecomesItsOwnCorrection) {
  const std::string text = same_holes(excellon(kBoard + std::string("M50,1\nM25\n") + kTargets +
                                               kCopies + "T1\n" + kUse + "T2\n" + kUse));
  EXPECT_THAT(text,
              HasSubstr("G31\nG39,SAVE1000\nM31\nM49,NOCAMA\nG39,LOAD1000\nX5.Y5.G32\nX45.Y5.G32\n"
                        "X5.Y45.G32\nG31\nG39,SAVE\nX0.Y0.M50\nX50.Y0.M50\n"));
  EXPECT_THAT(text, HasSubstr("M31\nM49,NOCAMA\nG39,LOAD\nX10.Y20.\nX40.Y30.\nX0.Y0.M50\n"));
}

TEST(StoredTranslation, HolesMayStandAmongTheTargetsPattern) {
  same_holes(excellon(kBoard + std::string("T1\nM50,1\nM25\n") + kTargets + "X7.Y7.\nX33.Y12.\n" +
                      kCopies + "X53.Y103.\nG47\nX80.Y90.\nT2\n" + kUse + "G37\nX1.Y2.\n"));
}

TEST(StoredTranslation, BehindG47TheBoardsCorrectionIsInForceInEveryCopy) {
  same_holes(excellon(kBoard + std::string("T1\nM50,1\nM25\nX8.Y8.\n") + kTargets +
                      "X7.Y7.\nG47\nX9.Y9.\n" + kCopies + kUse + "M25\nX2.Y2.\n" + kCopies +
                      "G47\nM25\nX2.Y2.\n" + kCopies),
             kSameOnPanel_um);
}

/// What a translation to SIEB & MEYER has no form for.
std::vector<std::string> refusals_of(const std::string& body) {
  const Translation lost = translate(excellon(body), Dialect::SiebMeyer);
  EXPECT_THAT(lost.errors, IsEmpty());
  EXPECT_EQ(lost.is_refused, !lost.losses.empty());
  return lost.losses;
}

/// The second copy would do it under the offset of the first, and in the other language under none.
TEST(StoredTranslation, RefusesAPlaceAheadOfTheOffsetThatACopyLeavesInForce) {
  const std::string contour = "G00X9.Y9.\nM15\nG01X12.\nM17\nG05\n";
  for (const std::string begin : {"T1\nM25\n", "T1\nM50,1\nM25\n"}) {
    for (const std::string& ahead : {std::string("X9.Y9.\n"), contour}) {
      const std::string pattern = kBoard + begin + ahead + "G45X5.Y5.\nX7.Y7.\n";
      EXPECT_THAT(refusals_of(pattern + kCopies + "G37\nX1.Y1.\n"),
                  ElementsAre(HasSubstr("under the nested correction of the copy before")));
      same_holes(excellon(pattern + "G47\n" + kCopies + "X1.Y1.\n"));
      same_holes(excellon(pattern + "M01\nM08\nG37\nX1.Y1.\n"));
    }
  }
}

/// The control ends an offset with the copy that it was measured in; one that was measured outside
/// of patterns comes back behind each copy.
TEST(StoredTranslation, AnOffsetFromOutsideOfPatternsEndsWithTheBoards) {
  const std::string outside = kBoard + std::string("T1\nG45X5.Y5.\nX4.Y4.\n");
  const std::string pattern = std::string("M25\nX1.Y1.\n") + kCopies;
  same_holes(excellon(outside + pattern + "X3.Y3.\nG37\nX2.Y2.\n" + pattern));
  same_holes(excellon(outside + "G37\nX3.Y3.\nG45X5.Y45.\nX2.Y2.\n"));
  const auto behind_g47 = ElementsAre(HasSubstr("behind G47 of a nested correction from outside"));
  EXPECT_THAT(refusals_of(outside + "G47\nX3.Y3.\n"), behind_g47);
  EXPECT_THAT(refusals_of(outside + pattern + "G47\nX3.Y3.\n"), behind_g47);
  EXPECT_THAT(refusals_of(outside + "M25\nX1.Y1.\nG47\n" + kCopies),
              ElementsAre(HasSubstr("G47 in a pattern, of a nested correction from outside")));
  for (const std::string own : {"M25\nG45X5.Y5.\nX1.Y1.\nG47\n", "M50,1\nM25\nG45X5.Y5.\n"}) {
    EXPECT_THAT(refusals_of(outside + "G47\n" + own + kCopies),
                testing::Contains(HasSubstr("a second nested correction")));
  }
}

/// Plunged again where it stands, the router does not move there first.
TEST(StoredTranslation, RefusesAContourBehindG47OfItsPattern) {
  EXPECT_THAT(refusals_of(kBoard +
                          std::string("T1\nM25\nG45X5.Y5.\nG00X30.Y30.\nM15\nG01X35.\n"
                                      "M17\nG47\nM15\nG01X40.\nM17\nG05\n") +
                          kCopies),
              ElementsAre(HasSubstr("behind G47 in the pattern of its nested correction")));
}

TEST(StoredTranslation, RefusesG47AheadOfTheTargets) {
  const std::string ahead = std::string("T1\nM50,1\nM25\nG47\nX8.Y8.\n") + kTargets + kCopies;
  const Translation lost = translate(excellon(kBoard + ahead), Dialect::SiebMeyer);
  EXPECT_TRUE(lost.is_refused);
  EXPECT_THAT(lost.losses, testing::Contains(HasSubstr("G47 ahead of the targets")));
}

TEST(StoredTranslation, WithoutABoardCorrection) {
  same_holes(
      excellon(std::string("T1\nM50,1\nM25\n") + kTargets + kCopies + kUse + "G47\nX1.Y1.\n"));
}

TEST(StoredTranslation, ABaseSeriesOrAnOffsetOfEachCopy) {
  const std::string base = "M50,3\nM25\nG36X5.Y5.\nG36X45.Y5.\nG36X5.Y45.\n";
  same_holes(
      excellon("T1\n" + base + kCopies + "M51,3\nM25\nM52,3\nX10.Y20.\n" + kCopies + "X1.Y1.\n"));
  for (const std::string command : {"G35", "G45"}) {
    same_holes(excellon(kBoard + std::string("T1\nM50,1\nM25\n") + command +
                        "X5.Y5.\nX7.Y7.\nG47\n" + kCopies + "M51,1\nM25\nM52\nX10.Y20.\nG47\n" +
                        kCopies + "G37\nX1.Y1.\n"));
  }
}

TEST(StoredTranslation, ContoursSlotsAndHolesAtTargets) {
  const std::string store = kBoard + ("T1\nM50,1\nM25\n" + std::string(kTargets)) +
                            "G38X20.Y20.\nG48X25.Y25.\n" + kCopies;
  const std::string contours =
      "X10.Y20.G85X20.Y20.\nG00X30.Y30.\nM15\nG01X35.Y30.\nG02X40.Y30.A2.5\nM17\nG05\nG47\n"
      "G00X30.Y10.\nM15\nG01X40.Y10.\nM17\nG05\n";
  same_holes(excellon(store + "M51,1\nM25\nM52,3\n" + contours + kCopies));
  same_holes(
      excellon(store + "M51,1\nM25\nM52,3\nG48X7.Y8.\nX9.Y9.\nG38X10.Y11.\nX12.Y12.\n" + kCopies));
}

TEST(StoredTranslation, MirroredAndTurnedCopies) {
  const std::string copies = "M01\nM02X100.M80\nM02Y100.M90\nM02X50.M70\nM08\n";
  same_holes(excellon(kBoard + std::string("T1\nM50,1\nM25\n") + kTargets + copies +
                      "M51,1\nM25\nM52,3\nX10.Y20.\n" + copies));
}

TEST(StoredTranslation, ANewLabelTakesTheLocationsOfTheOneBefore) {
  const std::string first = std::string("M50,1\nM25\n") + kTargets + kCopies;
  const std::string second = std::string("M50,2\nM25\n") + kTargets + kCopies;
  const std::string use_2 = "M51,2" + std::string(kUse).substr(5);
  same_holes(excellon(kBoard + ("T1\n" + first) + kUse + second + use_2));
  const Translation lost =
      translate(excellon(kBoard + ("T1\n" + first) + second + use_2 + kUse), Dialect::SiebMeyer);
  EXPECT_TRUE(lost.is_refused);
  EXPECT_THAT(lost.losses,
              ElementsAre(HasSubstr("the corrections of M50,1 behind those of another")));
}

/// Offset and rotation of two targets on a stretched board are no offset and rotation.
TEST(StoredTranslation, TwoTargetsCannotRepeatTheStretchOfABoard) {
  const std::string nested = "$uvis,alg,0,2\nM50,1\nM25\nG46X5.Y5.\nG46X45.Y45.\nX7.Y7.\n";
  const Translation lost =
      translate(excellon(kBoard + ("T1\n" + nested) + kCopies), Dialect::SiebMeyer);
  EXPECT_TRUE(lost.is_refused);
  EXPECT_THAT(lost.losses, testing::Contains(HasSubstr("a nested series of 2 targets")));
  same_holes(excellon("T1\n" + nested + kCopies));
  same_holes(excellon("T1\n$uvis,alg,0,2\nG36X0.Y0.\nG36X190.Y0.\n" + nested + kCopies));
}

/// datasets/demo: three targets of the panel, three of each of its six boards, seven drills.
TEST(StoredTranslation, TheDemoPanel) {
  const auto source = read_source(test::source_folder() / "datasets/demo/panel.exc");
  ASSERT_TRUE(source.has_value());
  WalkOptions options;
  options.model = PanelModel::Stretch;
  const std::string text =
      same_holes(source->bytes, 0.2, panel_of_boards({105.695, 85.026}, {10, 10}), options);
  EXPECT_THAT(text, HasSubstr("G39,SAVE1000\nM31\nM49,NOCAMA\nG39,LOAD1000\nX15.Y15.G32\n"));
}

TEST(StoredTranslation, RefusesWhatNoCopyCanKeep) {
  const auto errors_of = [](const std::string& body) {
    return translate(excellon("$uvis,alg,0,2\nT1\n" + body), Dialect::SiebMeyer).errors;
  };
  const std::string series = "G36X5.Y5.\nG36X45.Y5.\n";
  EXPECT_THAT(errors_of("M50,1\n" + series + "X1.Y1.\n"),
              ElementsAre(test::Reports("p:11:1: error[not-supported]",
                                        "\"G36\" completes a series outside of a pattern")));
  EXPECT_THAT(errors_of("M50,1\nM25\n" + series + "G46X5.Y5.\nG46X45.Y5.\nM01\nM08\n"),
              ElementsAre(test::Reports("p:14:1: error[not-supported]", "second series")));
  EXPECT_THAT(errors_of("M25\nM50,1\nX1.Y1.\nM01\nM08\n"),
              ElementsAre(test::Reports("p:10:1: error[not-supported]", "\"M50,1\" stands in")));
}

/// Copies that begin with another tool than the pattern did are written out.
TEST(StoredTranslation, RefusesPatternsWhoseCopiesAreWrittenOut) {
  const auto reports = [](int line, const std::string& text) {
    return ElementsAre(test::Reports("p:" + std::to_string(line) + ":1: error[not-supported]",
                                     text + " belongs to a pattern whose copies are written out"));
  };
  const auto errors_of = [](const std::string& body) {
    return translate(excellon(kBoard + std::string("T1\n") + body), Dialect::SiebMeyer).errors;
  };
  const std::string two_tools = "X1.Y1.\nT2\nX2.Y2.\nM01\nM02X50.\nM08\n";
  // The next pattern would be taken for one that stores.
  EXPECT_THAT(errors_of("M50,1\nM25\n" + two_tools + kBoard + "M25\n" + kTargets + "X7.Y7.\n" +
                        kCopies + "G47\nX9.Y9.\n"),
              reports(18, "\"M50,1\""));
  EXPECT_THAT(errors_of("M50,1\nM25\n" + std::string(kTargets) + two_tools),
              reports(15, "\"G46\""));
  const std::string stored = "M50,1\nM25\n" + std::string(kTargets) + "M01\nM02X50.\nM08\n";
  for (const std::string use : {"M51,1\nM25\nM52,3\n", "M51,1\nM25\nT1\nM52,3\n"}) {
    same_holes(excellon(kBoard + std::string("T1\n") + stored + use + two_tools));
  }
}

/// The board's model and the copy's would not be those of the one fit that stands for both.
TEST(StoredTranslation, RefusesNestedSeriesOfOtherModels) {
  const auto errors_of = [](const std::string& body, bool chooses, bool scales) {
    WalkOptions options;
    options.chooses_model = chooses;
    options.sieb_meyer.fits_scale = scales;
    return translate(excellon(body), Dialect::SiebMeyer, options).errors;
  };
  const auto is_named = [](int line) {
    return ElementsAre(test::Reports("p:" + std::to_string(line) + ":1: error[not-supported]",
                                     "\"G46\" completes a nested series whose model is not"));
  };
  const std::string three = kBoard + ("T1\nM50,1\nM25\n" + std::string(kTargets)) + kCopies;
  const std::string two = "$uvis,alg,0,2\nM50,1\nM25\nG46X5.Y5.\nG46X45.Y45.\nM01\nM08\n";
  EXPECT_THAT(errors_of(three, true, false), is_named(15));
  EXPECT_THAT(errors_of(three, false, true), IsEmpty());
  EXPECT_THAT(errors_of(two, false, true), is_named(11));
}

/// Locations 1 to 1000, of which the board's correction takes the last where copies replace it.
TEST(StoredTranslation, AThousandCopiesHaveLocations) {
  const auto copies = [](int n) { return fmt::format("M01\nR{}M02X.1\nM02\nM08\n", n - 1); };
  const std::string base = "T1\nM50,1\nM25\nG36X5.Y5.\nG36X45.Y5.\nG36X5.Y45.\n";
  const std::string nested = kBoard + ("T1\nM50,1\nM25\n" + std::string(kTargets));
  const auto are_refused = [](int n, int n_most) {
    return ElementsAre(testing::AllOf(HasSubstr(fmt::format("{} copies that store", n)),
                                      HasSubstr(fmt::format("at most {}", n_most))));
  };
  EXPECT_THAT(refusals_of(base + copies(1001)), are_refused(1001, 1000));
  EXPECT_THAT(refusals_of(nested + copies(1000)), are_refused(1000, 999));
  // 1000 copies are not refused, but then the board takes the location of the last.
  EXPECT_THAT(
      refusals_of(base + copies(1000) + "M50,2\nM25\nX1.Y1.\nM01\nM08\nM51,1\nM25\nM52,3\n" +
                  "X1.Y1.\n" + copies(1000)),
      ElementsAre(HasSubstr("the corrections of M50,1 behind those of another")));
}

}  // namespace
}  // namespace panelcal
