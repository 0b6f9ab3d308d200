// SPDX-License-Identifier: Apache-2.0
// Corrections that a program keeps by number, takes back outside of patterns, or nests without
// keeping them, in the other language.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/writers/translation/boards.h"
#include "tests/support/folders.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::boards_in_excellon;
using test::FunctionSource;
using test::kSameFit_um;
using test::kSameOnPanel_um;
using test::panel_of_boards;
using test::Reports;
using test::same_holes;
using test::sieb_meyer;
using test::small_boards;
using test::translate;
using test::Translation;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string same_fits(const std::string& text, std::size_t n_losses = 0) {
  return same_holes(text, kSameFit_um, small_boards(), {}, n_losses);
}

std::vector<std::string> refused_of(const std::string& text, const WalkOptions& options = {}) {
  const Translation translation = translate(text, test::other_language(text), options);
  EXPECT_THAT(translation.errors, IsEmpty());
  EXPECT_TRUE(translation.is_refused);
  return translation.losses;
}

// --- from SIEB & MEYER: G39 --------------------------------------------------------------------

constexpr char kPanel[] = "X0.Y0.G32\nX190.Y0.G32\nX0.Y190.G32\nG31\n";
constexpr char kPanelAgain[] = "X10.Y10.G32\nX180.Y10.G32\nX10.Y180.G32\nG31\n";
constexpr char kSavingSection[] =
    "M31\nG34\nX5.Y5.G32\nX45.Y5.G32\nX5.Y45.G32\nG31\nG39,SAVE\n"
    "X0.Y0.M50\nX50.Y0.M50\nX0.Y50.M50\nX100.Y50.M90M30\n";

TEST(SetTranslation, SavedByNumberIsStoredInAPatternOfItsOwn) {
  const std::string text = same_fits(
      sieb_meyer(std::string(kPanel) + "G39,SAVE7\nX10.Y20.T1\nG34\n" + kPanelAgain +
                 "G39,SAVE2\nX30.Y40.\nG39,LOAD7\nX50.Y60.\nG30\nX1.Y1.\nG39,LOAD2\nX5.Y9."
                 "\nG39,CLEAR7\nG39,DELALL\nX9.Y9.\n"));
  EXPECT_THAT(text,
              HasSubstr("M50,1\nM25\nG34,1\n$uvis,alg,0,3\nG36X0.0Y0.0\nG36X190.0Y0.0\n"
                        "G36X0.0Y190.0\nM01\nM08\nT1\nX10.0Y20.0\nG37\nM50,2\nM25\n"));
  EXPECT_THAT(text, HasSubstr("X30.0Y40.0\nM51,1\nM52,3\nX50.0Y60.0\nG37\nX1.0Y1.0\nM51,2\n"));
}

TEST(SetTranslation, ALoadedCorrectionHoldsInSections) {
  same_fits(sieb_meyer(std::string(kPanel) +
                       "G39,SAVE7\nG30\nX10.Y20.T1\nG39,LOAD7\nM31\nX3.Y4.\nX0.Y0.M50\n"
                       "X50.Y0.M50M30\nX5.Y5.\n"));
}

TEST(SetTranslation, TheCorrectionOfACopyCountsOutsideOfItsSection) {
  const std::string text = same_fits(sieb_meyer(
      kSavingSection + std::string("T1\nG39,LOAD2\nX60.Y20.\nG39,LOAD4\nX70.Y30.\nG39,LOAD1\n"
                                   "X10.Y20.\nM31\nX3.Y4.\nX0.Y0.M50\nX50.Y0.M50M30\nG30\nM31\n"
                                   "X3.Y4.\nX0.Y0.M50\nX50.Y0.M50M30\n")));
  EXPECT_THAT(text, HasSubstr("M51,1\nM52,6\nX60.0Y20.0\nM52,6\nX70.0Y30.0\nM51,1\nM52,3\n"));
  // While M52 has left points, M08 of a pattern would wait for them; all have to be passed.
  EXPECT_THAT(
      text, HasSubstr("M52,3\nX10.0Y20.0\nX3.0Y4.0\nX53.0Y4.0\nM52,9\nG37\nM25\nX3.0Y4.0\nM01\n"));
}

TEST(SetTranslation, BoardsMayBeLeftOut) {
  const std::string text = same_fits(sieb_meyer(
      kSavingSection + std::string("T1\nM31\nG39,LOAD\nX10.Y20.\nX0.Y0.M50\nX50.Y0.M50M30\n")));
  EXPECT_THAT(text, HasSubstr("M51,1\nM52,3\nX10.0Y20.0\nM52,3\nX60.0Y20.0\nM52,6\nM30\n"));
}

TEST(SetTranslation, WorkAheadOfLoadIsUnderTheCorrectionBefore) {
  const std::string text = same_fits(sieb_meyer(
      kSavingSection +
      std::string("T1\nM31\nX9.Y9.\nG39,LOAD\nX1.Y1.\nX0.Y0.M50\nX50.Y0.M50\nX0.Y50.M50\n"
                  "X100.Y50.M90M30\n" +
                  std::string(kSavingSection))));
  EXPECT_THAT(text, HasSubstr("X9.0Y9.0\nM51,1\nM52,3\nX1.0Y1.0\nX59.0Y9.0\nM52,3\nX51.0Y1.0\n"));
}

TEST(SetTranslation, ASectionMayLoadTheCorrectionOfTheBoard) {
  const std::string text = same_fits(
      sieb_meyer(std::string(kPanel) + "G39,SAVE7\n" + kSavingSection +
                 "T1\nM31\nG39,LOAD7\nX3.Y4.\nG39,LOAD\nX10.Y20.\nX0.Y0.M50\nX50.Y0.M50M30\n"));
  EXPECT_THAT(text,
              HasSubstr("M51,1\nM52,3\nX3.0Y4.0\nM51,2\nM52,3\nX10.0Y20.0\nM52,9\nM51,1\nM52,3\n"));
}

/// A copy's own offset (G36 under CAMA) is saved with its board's correction, and ends with it.
TEST(SetTranslation, ACopyKeepsItsOffsetToo) {
  const std::string text = same_fits(sieb_meyer(
      "M49,CAMA\nM31\nG34\nX5.Y5.G32\nX45.Y5.G32\nX5.Y45.G32\nG31\nX25.Y25.G36\nG39,SAVE\n"
      "X0.Y0.M50\nX50.Y0.M50M30\nT1\nM31\nG39,LOAD\nX10.Y20.\nX0.Y0.M50\nX50.Y0.M50M30\nX1.Y1.\n"));
  EXPECT_THAT(text, HasSubstr("M25\nM52,4\nX10.0Y20.0\nG47\nM01\n"));
  const std::string back = same_fits(text);
  EXPECT_THAT(back, HasSubstr("G31\nG39,SAVE\nM49,CAMA\nX25.Y25.G36\nG39,SAVE\n"));
  EXPECT_THAT(same_fits(back), HasSubstr("M25\nM52,4\nX10.0Y20.0\nG47\nM01\n"));
}

/// What is loaded to find the targets under it is left out, and named.
TEST(SetTranslation, TargetsAreLookedForAtTheirNominalPlaces) {
  const std::string text =
      sieb_meyer(std::string(kPanel) +
                 "G39,SAVE1000\nM31\nG39,LOAD1000\nX5.Y5.G32\nX45.Y5.G32\nX5.Y45.G32\n"
                 "G31\nG39,SAVE\nX10.Y20.T1\nX0.Y0.M50\nX50.Y0.M50M30\n");
  same_fits(text, 1);
  EXPECT_THAT(translate(text, Dialect::Excellon).losses,
              ElementsAre(Reports("p:8: warning[translation-loss]", "looking for targets")));
}

TEST(SetTranslation, NamesWhatExcellonCannotSay) {
  const auto named = [](const std::string& line, const std::string& order) {
    return Reports("p:" + line + ": error[translation-refused]", "\"" + order + "\"");
  };
  EXPECT_THAT(refused_of(sieb_meyer(std::string(kPanel) + "X1.Y1.T1\nG30\nG31\nX2.Y2.\n")),
              ElementsAre(named("8", "G31")));
  EXPECT_THAT(refused_of(sieb_meyer(std::string(kPanel) + "G39,SPOP\nG39,SAVE\nX1.Y1.T1\n")),
              ElementsAre(named("6", "G39,SPOP"), named("7", "G39,SAVE")));
  EXPECT_THAT(refused_of(sieb_meyer("M31\nG34\nX5.Y5.G32\nG31\nG39,SAVE3\nX1.Y1.T1\nX0.Y0.M50\n"
                                    "X50.Y0.M50M30\nG39,LOAD3\nX2.Y2.\n")),
              ElementsAre(named("6", "G39,SAVE3"), named("10", "G39,LOAD3")));
  EXPECT_THAT(refused_of(sieb_meyer("M31\nG34\nX5.Y5.G32\nG31\nG39,SAVE\nX6.Y6.G32\nG31\nX1.Y1.T1"
                                    "\nX0.Y0.M50\nX50.Y0.M50M30\n")),
              ElementsAre(named("8", "G31")));
  EXPECT_THAT(
      refused_of(sieb_meyer(std::string(kPanel) + "X1.Y1.T1\nG39,SAVE1\nG34\nG39,LOAD1\nX2.Y2.\n")),
      ElementsAre(Reports("p:9: error[translation-refused]", "saved behind other work")));
}

/// A slot shows one coordinate (mode 5), and Excellon measures one layer (2 and 3).
TEST(SetTranslation, RefusesSlotsAndLayersInExcellon) {
  const auto refused_in_mode = [](int mode, const std::string& first) {
    WalkOptions options;
    options.sieb_meyer.measurement_mode = mode;
    const std::string text = sieb_meyer(
        "X5.Y5." + first + "\nX5.Y5.G33\nX45.Y5.G33\nX5.Y45.G32\nX5.Y45.G33\nG31\nX1.Y1.T1\n");
    return refused_of(text, options);
  };
  const auto named = [](const std::string& line, const std::string& order) {
    return Reports("p:" + line + ": error[translation-refused]", "\"" + order + "\"");
  };
  EXPECT_THAT(refused_in_mode(2, "G32"), ElementsAre(named("2", "G32"), named("5", "G32")));
  EXPECT_THAT(refused_in_mode(3, "G32"), ElementsAre(named("2", "G32"), named("5", "G32")));
  EXPECT_THAT(refused_in_mode(5, "G33"),
              ElementsAre(named("2", "G33"),
                          named("3", "G33"),
                          named("4", "G33"),
                          named("5", "G32"),
                          named("6", "G33"),
                          named("7", "G31")));
  WalkOptions layers;
  layers.sieb_meyer.measurement_mode = 2;
  const std::string single = "X5.Y5.G33\nX45.Y5.G33\nX5.Y45.G33\nG31\nX1.Y1.T1\n";
  same_holes(sieb_meyer(single), kSameFit_um, small_boards(), layers);
}

// --- from SIEB & MEYER: G39,REQCOMP, answered by the fit of the targets since ------------------

WalkOptions mode_3() {
  WalkOptions options;
  options.sieb_meyer.measurement_mode = 3;
  return options;
}

std::string same_requests(const std::string& body) {
  return same_holes(sieb_meyer(body), kSameFit_um, small_boards(), mode_3());
}

constexpr char kPanelLayers[] = "X0.Y0.G33\nX190.Y0.G33\nX0.Y190.G33\n";

TEST(SetTranslation, ARequestedCorrectionIsTheFitOfItsTargets) {
  const std::string first = kPanelLayers + std::string("G39,REQCOMP\n");
  const std::string text = same_requests(first + "X1.Y1.T1\nG34\nX2.Y2.\nG34\n" + first);
  EXPECT_THAT(text, HasSubstr("G36X0.0Y190.0\nT1\nX1.0Y1.0\nG37\nX2.0Y2.0\nG37\nG36X0.0Y0.0\n"));
  // In force already: by G31, by itself.
  for (const std::string again : {"G31\n", "G39,REQCOMP\n", "G31\nG39,REQCOMP\nG31\n"}) {
    EXPECT_EQ(same_requests(first + again + "X1.Y1.T1\n"), same_requests(first + "X1.Y1.T1\n"));
    same_requests(kPanelLayers + std::string("G31\nX3.Y3.T1\n") + again + "X1.Y1.T1\n");
  }
  same_requests(first + "G39,SAVE7\nX10.Y20.T1\nG34\nX30.Y40.\nG39,LOAD7\nX50.Y60.\n");
  const std::string copies = "X0.Y0.M50\nX50.Y0.M50M30\n";
  EXPECT_THAT(same_requests("M31\nG34\nX5.Y5.G33\nX45.Y5.G33\nX5.Y45.G33\nG39,REQCOMP\nG31\n"
                            "G39,SAVE\n" +
                            copies + "M31\nG39,LOAD\nX10.Y20.T1\n" + copies),
              HasSubstr("M51,1\nM25\nM52,3\n"));
}

TEST(SetTranslation, RefusesARequestOfWhatAnotherOrderHasEnded) {
  const std::string first = kPanelLayers + std::string("G39,REQCOMP\nX1.Y1.T1\n");
  const auto reports = [](const std::string& line, const std::string& order) {
    return ElementsAre(Reports("p:" + line + ": error[translation-refused]",
                               "\"" + order +
                                   "\" has no form in Excellon CNC-7; expected G34 and "
                                   "its targets (G33) once more before it"));
  };
  EXPECT_THAT(refused_of(sieb_meyer(first + "G30\nG39,REQCOMP\nX2.Y2.\n"), mode_3()),
              reports("8", "G39,REQCOMP"));
  EXPECT_THAT(refused_of(sieb_meyer(first + "G30\nG31\nX2.Y2.\n"), mode_3()), reports("8", "G31"));
  // The remedy.
  same_requests(first + "G30\nG34\n" + kPanelLayers + "G39,REQCOMP\nX2.Y2.\n");
  same_requests(first + "G30\nG34\n" + kPanelLayers + "G31\nX2.Y2.\n");
  // The second copy begins with the correction off, and turns it on.
  const std::string copies = "X0.Y0.M50\nX50.Y0.M50M30\n";
  EXPECT_THAT(refused_of(sieb_meyer(first + "M31\nG31\nX2.Y2.\nG30\n" + copies), mode_3()),
              reports("8", "G31"));
  // Layers, in whose mode alone the order is allowed.
  EXPECT_THAT(refused_of(sieb_meyer("X1.Y1.G32\n" + first), mode_3()),
              testing::Contains(testing::EndsWith("expected one layer of each target: G33 alone")));
}

// --- from Excellon: M51, M52 and nested series -------------------------------------------------

constexpr char kPanelTargets[] = "G36X0.Y0.\nG36X190.Y0.\nG36X0.Y190.\n";
constexpr char kBoardTargets[] = "G46X5.Y5.\nG46X45.Y5.\nG46X5.Y45.\n";
constexpr char kTwoCopies[] = "M01\nM02X50.\nM08\n";

TEST(SetTranslation, AReplayWithoutM25LoadsByNumber) {
  const std::string text = same_holes(
      boards_in_excellon(kPanelTargets + std::string("T1\nM50,1\nM25\n") + kBoardTargets +
                         "M01\nR3M02X50.\nM08\nM51,1\nM52,3\nX10.Y20.\nM52\nM52\nM52,4\n"
                         "X110.Y20.\nG47\nX1.Y1.\nM52,3\nX160.Y9.\nM25\nX3.Y3.\n" +
                         kTwoCopies),
      kSameOnPanel_um);
  EXPECT_THAT(text,
              HasSubstr("M49,NOCAMA\nG39,LOAD1\nX10.Y20.\nG39,LOAD3\nX110.Y20.\nG39,LOAD1000"
                        "\nX1.Y1.\nG39,LOAD4\nX160.Y9.\n"));
}

TEST(SetTranslation, CopiesThatTakeToolsLoadByNumber) {
  const std::string text = same_holes(
      boards_in_excellon("T1\nM50,1\nM25\nG35X5.Y5.\nM01\nM02X50.\nM08\nM51,1\nM25\nM52\nX10.Y20.\n"
                         "M01\nM02X50.T2\nM08\nX1.Y1.\n"),
      kSameFit_um);
  EXPECT_THAT(text, HasSubstr("G39,LOAD1\nX10.Y20.\nG39,LOAD2\nX60.Y20.T2\n"));
}

TEST(SetTranslation, ANestedSeriesNeedsNoM50) {
  const std::string nested = "M25\nX8.Y8.\n" + std::string(kBoardTargets) + "X7.Y7.\n";
  const std::string text = same_holes(boards_in_excellon(kPanelTargets + ("T1\n" + nested) +
                                                         kTwoCopies + "X60.Y20.\nG47\nX1.Y1.\n"));
  EXPECT_THAT(text,
              HasSubstr("G39,SAVE1000\nT1\nM31\nX8.Y8.\nM49,NOCAMA\nG39,LOAD1000\nX5.Y5.G32\n"));
  EXPECT_THAT(text, HasSubstr("M30\nX60.Y20.\nG39,LOAD1000\nX1.Y1.\n"));
  same_holes(boards_in_excellon(kPanelTargets + ("T1\n" + nested) + "G47\nX9.Y9.\n" + kTwoCopies +
                                "X1.Y1.\n"),
             kSameOnPanel_um);
  same_holes(boards_in_excellon("T1\n" + nested + kTwoCopies + "G47\nX1.Y1.\n"));
  same_holes(boards_in_excellon(kPanelTargets + std::string("T1\nM25\nG47\n") + kBoardTargets +
                                "X7.Y7.\n" + kTwoCopies + "M25\nG47\nX2.Y2.\n" + kBoardTargets +
                                "X7.Y7.\n" + kTwoCopies));
}

TEST(SetTranslation, NestedSeriesReplaceEachOther) {
  const std::string second = "G46X55.Y5.\nG46X95.Y5.\nG46X55.Y45.\n";
  const std::string text = same_holes(
      boards_in_excellon(kPanelTargets + std::string("T1\n") + kBoardTargets + "X7.Y7.\n" + second +
                         "X60.Y10.\nG47\nX1.Y1.\n" + kBoardTargets + "X20.Y30.\nG37\nX2.Y2.\n"));
  EXPECT_THAT(text, HasSubstr("G31\nM49,NOCAMA\nG39,SAVE1000\nX5.Y5.G32\n"));
  EXPECT_THAT(text, HasSubstr("X7.Y7.T1\nG39,LOAD1000\nX55.Y5.G32\n"));
  EXPECT_THAT(text, HasSubstr("X60.Y10.\nG39,LOAD1000\nX1.Y1.\nX5.Y5.G32\n"));
}

TEST(SetTranslation, ABaseSeriesAndANestedOneInEachCopy) {
  same_holes(boards_in_excellon("T1\nM25\nX8.Y8.\nG36X2.Y2.\nG36X48.Y2.\nG36X2.Y48.\nX9.Y9.\n" +
                                std::string(kBoardTargets) + "X7.Y7.\nG47\nX20.Y20.\n" +
                                kTwoCopies + "X1.Y1.\n"),
             kSameOnPanel_um);
}

TEST(SetTranslation, ACopyStoresItsBoardAndItsOffset) {
  const std::string stored =
      "T1\nM50,1\nM25\nG36X2.Y2.\nG36X48.Y2.\nG36X2.Y48.\nG45X25.Y25.\nG47\n";
  const std::string use = "M51,1\nM25\nM52,3\nM52\nX7.Y7.\nG47\n";
  const std::string text =
      same_fits(boards_in_excellon(stored + kTwoCopies + use + kTwoCopies +
                                   "X1.Y1.\nM51,1\nM52,4\nX3.Y3.\nM52,4\nX53.Y3.\nG37\nX2.Y2.\n"));
  EXPECT_THAT(text, HasSubstr("M31\nM49,CAMA\nG39,LOAD\nX7.Y7.\nX0.Y0.M50\n"));
  EXPECT_THAT(text, HasSubstr("G39,LOAD1\nX3.Y3.\nG39,LOAD2\nX53.Y3.\nG34\n"));
  const Translation part =
      translate(boards_in_excellon(stored + kTwoCopies +
                                   "M51,1\nM25\nM52,3\nX7.Y7.\nM52\nX8.Y8.\nG47\n" + kTwoCopies),
                Dialect::SiebMeyer);
  EXPECT_THAT(part.errors,
              ElementsAre(Reports("p:21:1: error[not-supported]", "under a part of a copy's")));
}

TEST(SetTranslation, NamesNestedCorrectionsThatWouldGoElsewhere) {
  const std::string panel = kPanelTargets + std::string("T1\n");
  // Two targets give no stretch.
  EXPECT_THAT(
      refused_of(boards_in_excellon(panel + "$uvis,alg,0,2\nG46X5.Y5.\nG46X45.Y5.\nX1.Y1.\n")),
      ElementsAre(HasSubstr("a nested series of 2 targets")));
  // In the second copy the first hole is under the correction of the first copy.
  const std::string offset = "M25\nX8.Y8.\nG45X5.Y5.\nX7.Y7.\n";
  EXPECT_THAT(refused_of(boards_in_excellon(panel + offset + kTwoCopies)),
              ElementsAre(HasSubstr("under the nested correction of the copy before")));
  same_holes(boards_in_excellon(panel + offset + "G47\n" + kTwoCopies + "X1.Y1.\n"), kSameFit_um);
  // In the first copy G47 has nothing to cancel.
  EXPECT_THAT(refused_of(boards_in_excellon(panel + "M25\nG47\nX8.Y8.\n" + kBoardTargets +
                                            "X7.Y7.\n" + kTwoCopies)),
              ElementsAre(HasSubstr("G47 ahead of the targets")));
}

/// Also where no M50 keeps them.
TEST(SetTranslation, RefusesNestedSeriesOfOtherModels) {
  const auto refused_with = [](bool chooses, bool scales, const std::string& body) {
    WalkOptions options;
    options.chooses_model = chooses;
    options.sieb_meyer.fits_scale = scales;
    return refused_of(boards_in_excellon("T1\n" + body + "X1.Y1.\n"), options);
  };
  const auto is_named = ElementsAre(HasSubstr("a nested series whose model is not the manual's"));
  EXPECT_THAT(refused_with(true, false, std::string(kPanelTargets) + kBoardTargets), is_named);
  EXPECT_THAT(refused_with(false, true, "$uvis,alg,0,2\nG46X5.Y5.\nG46X45.Y45.\n"), is_named);
}

/// [vision] scale: a SIEB & MEYER control fits it to two targets of G31, an Excellon one does not.
TEST(SetTranslation, RefusesAScaleFittedToTwoTargets) {
  WalkOptions scales;
  scales.sieb_meyer.fits_scale = true;
  const std::string two = "X5.Y5.G32\nX45.Y45.G32\nG31\nX1.Y1.T1\n";
  EXPECT_THAT(refused_of(sieb_meyer(two), scales),
              ElementsAre(Reports("p:4: error[translation-refused]", "a scale fitted to two")));
  EXPECT_THAT(
      refused_of(boards_in_excellon("$uvis,alg,0,2\nT1\nG36X0.Y0.\nG36X190.Y0.\nX1.Y1.\n"), scales),
      ElementsAre(HasSubstr("without the scale that the control fits")));
  same_fits(sieb_meyer(two));
}

/// A control counts the targets of its patterns' offsets together until G34, also behind G30, G31
/// and G39,LOAD; an offset from outside of sections comes back behind them.
TEST(SetTranslation, RefusesOffsetsThatTheControlPutsTogether) {
  const std::string first = kPanel + std::string("G39,SAVE7\nM49,CAMA\nX5.Y5.G36\nX1.Y1.T1\n");
  const std::string second = "X5.Y45.G36\nX2.Y2.\n";
  for (const std::string between : {"", "G30\n", "X9.Y9.G32\nG31\n", "G39,LOAD7\n"}) {
    EXPECT_THAT(refused_of(sieb_meyer(first + between + second)),
                testing::Contains(HasSubstr("one offset of a pattern from several targets")));
  }
  same_fits(sieb_meyer(first + "G34\n" + second));
  const std::string section = "M31\nG39,LOAD7\nX3.Y3.\nX0.Y0.M50\nX50.Y0.M50M30\nX4.Y4.\n";
  EXPECT_THAT(refused_of(sieb_meyer(first + section)),
              ElementsAre(Reports("p:11: error[translation-refused]", "\"G39,LOAD7\"")));
  same_fits(sieb_meyer(first + "G39,LOAD7\n" + section));
}

/// datasets/demo there and back: six boards whose corrections are fitted at once come back with
/// the same fits. Targets are looked for where they are nominally.
TEST(SetTranslation, TheDemoPanelThereAndBack) {
  const auto source = read_source(test::source_folder() / "datasets/demo/panel.exc");
  ASSERT_TRUE(source.has_value());
  WalkOptions options;
  options.model = PanelModel::Stretch;
  const FunctionSource panel = panel_of_boards({105.695, 85.026}, {10, 10});
  const std::string there = same_holes(source->bytes, 0.2, panel, options);
  const std::string back = same_holes(there, kSameFit_um, panel, options, 1);
  EXPECT_THAT(back, HasSubstr("M50,2\nM25\n$uvis,alg,0,3\nG36X15.0Y15.0\n"));
  EXPECT_THAT(back, HasSubstr("M51,2\nM25\nM52,3\n"));
  const std::string again = same_holes(back, kSameFit_um, panel, options);
  EXPECT_THAT(again, HasSubstr("G31\nG39,SAVE\n"));
}

}  // namespace
}  // namespace panelcal
