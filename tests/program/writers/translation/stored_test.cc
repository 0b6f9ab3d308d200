// SPDX-License-Identifier: Apache-2.0
// Corrections that copies keep for later patterns, in both languages: M50, M51 and M52; G39,SAVE
// and G39,LOAD. Run on the same panel, source and translation drill the same holes.
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/program/writers/translation/boards.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::difference_of_work;
using test::distance_um;
using test::excellon_boards;
using test::FunctionSource;
using test::kSameOnBoard_um;
using test::kSameOnPanel_um;
using test::other;
using test::panel_of_boards;
using test::Reports;
using test::run_on;
using test::same_holes;
using test::sieb_meyer_boards;
using test::small_boards;
using test::translate;
using test::Translation;
using test::WorkRun;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr char kBoard[] = "G36X0.Y0.\nG36X190.Y0.\nG36X0.Y190.\n";
constexpr char kTargets[] = "G46X5.Y5.\nG46X45.Y5.\nG46X5.Y45.\n";
constexpr char kCopies[] = "M01\nR1M02X50.\nM01\nR2M02Y50.\nM08\n";
constexpr char kUse[] =
    "M51,1\nM25\nM52,3\nX10.Y20.\nX40.Y30.\nM01\nR1M02X50.\nM01\nR2M02Y50.\nM08\n";

// --- from Excellon -----------------------------------------------------------------------------

TEST(StoredTranslation, ACopysNestedSeriesBecomesItsOwnCorrection) {
  const std::string text = same_holes(excellon_boards(
      kBoard + std::string("M50,1\nM25\n") + kTargets + kCopies + "T1\n" + kUse + "T2\n" + kUse));
  EXPECT_THAT(text,
              HasSubstr("G31\nG39,SAVE1000\nM31\nM49,NOCAMA\nG39,LOAD1000\nX5.Y5.G32\nX45.Y5.G32\n"
                        "X5.Y45.G32\nG31\nG39,SAVE\nX0.Y0.M50\nX50.Y0.M50\n"));
  EXPECT_THAT(text, HasSubstr("M31\nM49,NOCAMA\nG39,LOAD\nX10.Y20.\nX40.Y30.\nX0.Y0.M50\n"));
}

TEST(StoredTranslation, HolesMayStandAmongTheTargetsPattern) {
  same_holes(excellon_boards(kBoard + std::string("T1\nM50,1\nM25\n") + kTargets +
                             "X7.Y7.\nX33.Y12.\n" + kCopies + "X53.Y103.\nG47\nX80.Y90.\nT2\n" +
                             kUse + "G37\nX1.Y2.\n"));
}

TEST(StoredTranslation, BehindG47TheBoardsCorrectionIsInForceInEveryCopy) {
  same_holes(excellon_boards(kBoard + std::string("T1\nM50,1\nM25\nX8.Y8.\n") + kTargets +
                             "X7.Y7.\nG47\nX9.Y9.\n" + kCopies + kUse + "M25\nX2.Y2.\n" + kCopies +
                             "G47\nM25\nX2.Y2.\n" + kCopies),
             kSameOnPanel_um);
}

TEST(StoredTranslation, RefusesG47AheadOfTheTargets) {
  const std::string ahead = std::string("T1\nM50,1\nM25\nG47\nX8.Y8.\n") + kTargets + kCopies;
  const Translation lost = translate(excellon_boards(kBoard + ahead), Dialect::SiebMeyer);
  EXPECT_TRUE(lost.is_refused);
  EXPECT_THAT(lost.losses, testing::Contains(HasSubstr("G47 ahead of the targets")));
}

TEST(StoredTranslation, WithoutABoardCorrection) {
  same_holes(excellon_boards(std::string("T1\nM50,1\nM25\n") + kTargets + kCopies + kUse +
                             "G47\nX1.Y1.\n"));
}

TEST(StoredTranslation, ABaseSeriesOrAnOffsetOfEachCopy) {
  const std::string base = "M50,3\nM25\nG36X5.Y5.\nG36X45.Y5.\nG36X5.Y45.\n";
  same_holes(excellon_boards("T1\n" + base + kCopies + "M51,3\nM25\nM52,3\nX10.Y20.\n" + kCopies +
                             "X1.Y1.\n"));
  for (const std::string command : {"G35", "G45"}) {
    same_holes(excellon_boards(kBoard + std::string("T1\nM50,1\nM25\n") + command +
                               "X5.Y5.\nX7.Y7.\nG47\n" + kCopies +
                               "M51,1\nM25\nM52\nX10.Y20.\nG47\n" + kCopies + "G37\nX1.Y1.\n"));
  }
}

TEST(StoredTranslation, MirroredAndTurnedCopies) {
  const std::string copies = "M01\nM02X100.M80\nM02Y100.M90\nM02X50.M70\nM08\n";
  same_holes(excellon_boards(kBoard + std::string("T1\nM50,1\nM25\n") + kTargets + copies +
                             "M51,1\nM25\nM52,3\nX10.Y20.\n" + copies));
}

TEST(StoredTranslation, ANewLabelTakesTheLocationsOfTheOneBefore) {
  const std::string first = std::string("M50,1\nM25\n") + kTargets + kCopies;
  const std::string second = std::string("M50,2\nM25\n") + kTargets + kCopies;
  const std::string use_2 = "M51,2" + std::string(kUse).substr(5);
  same_holes(excellon_boards(kBoard + ("T1\n" + first) + kUse + second + use_2));
  const Translation lost = translate(
      excellon_boards(kBoard + ("T1\n" + first) + second + use_2 + kUse), Dialect::SiebMeyer);
  EXPECT_TRUE(lost.is_refused);
  EXPECT_THAT(lost.losses,
              ElementsAre(HasSubstr("the corrections of M50,1 behind those of another")));
}

/// Offset and rotation of two targets on a stretched board are no offset and rotation.
TEST(StoredTranslation, TwoTargetsCannotRepeatTheStretchOfABoard) {
  const std::string nested = "$uvis,alg,0,2\nM50,1\nM25\nG46X5.Y5.\nG46X45.Y45.\nX7.Y7.\n";
  const Translation lost =
      translate(excellon_boards(kBoard + ("T1\n" + nested) + kCopies), Dialect::SiebMeyer);
  EXPECT_TRUE(lost.is_refused);
  EXPECT_THAT(lost.losses, testing::Contains(HasSubstr("a nested series of 2 targets")));
  same_holes(excellon_boards("T1\n" + nested + kCopies));
  same_holes(excellon_boards("T1\n$uvis,alg,0,2\nG36X0.Y0.\nG36X190.Y0.\n" + nested + kCopies));
}

/// datasets/demo: three targets of the panel, three of each of its six boards, seven drills.
TEST(StoredTranslation, TheDemoPanel) {
  const auto source = read_source(PANELCAL_SOURCE_DIR "/datasets/demo/panel.exc");
  ASSERT_TRUE(source.has_value());
  WalkOptions options;
  options.model = PanelModel::Stretch;
  const std::string text =
      same_holes(source->bytes, 0.2, panel_of_boards({105.695, 85.026}, {10, 10}), options);
  EXPECT_THAT(text, HasSubstr("G39,SAVE1000\nM31\nM49,NOCAMA\nG39,LOAD1000\nX15.Y15.G32\n"));
}

TEST(StoredTranslation, RefusesWhatNoCopyCanKeep) {
  const auto errors_of = [](const std::string& body) {
    return translate(excellon_boards("$uvis,alg,0,2\nT1\n" + body), Dialect::SiebMeyer).errors;
  };
  const std::string series = "G36X5.Y5.\nG36X45.Y5.\n";
  EXPECT_THAT(errors_of("M50,1\n" + series + "X1.Y1.\n"),
              ElementsAre(Reports("p:11:1: error[not-supported]", "outside of such a pattern")));
  EXPECT_THAT(errors_of("M50,1\nM25\n" + series + "G46X5.Y5.\nG46X45.Y5.\nM01\nM08\n"),
              ElementsAre(Reports("p:14:1: error[not-supported]", "second series")));
  EXPECT_THAT(
      errors_of("M50,1\nM25\n" + series + "M01\nM08\nM25\nM51,1\nM52,2\nX1.Y1.\nM01\nM08\n"),
      ElementsAre(Reports("p:16:1: error[not-supported]", "\"M51,1\" in a pattern")));
}

// --- from SIEB & MEYER -------------------------------------------------------------------------

constexpr char kOffsets[] = "X0.Y0.M50\nX50.Y0.M50\nX0.Y50.M50\nX100.Y50.M90M30\n";

/// SIEB & MEYER CNC 8x.00 Command Set, G39, Example.
TEST(StoredTranslation, TheManualsExampleOfG39) {
  const std::string text = same_holes(sieb_meyer_boards(
      "M31\nG34\nX5.Y5.G32\nX45.Y45.G32\nG31\nG39,SAVE\nG30\n" + std::string(kOffsets) +
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
  const std::string text = same_holes(sieb_meyer_boards(first + use + second + use));
  EXPECT_THAT(text, HasSubstr("M51,2\nM25\nM52,3\n"));
}

// --- random programs ---------------------------------------------------------------------------

std::string random_holes() {
  std::string text;
  for (int n = *rc::gen::inRange(1, 4); n > 0; --n) {
    text += fmt::format("X{}.Y{}.\n", *rc::gen::inRange(1, 49), *rc::gen::inRange(1, 49));
  }
  return text;
}

bool may() {
  return *rc::gen::arbitrary<bool>();
}

/// Copies by step and repeat, and their number.
struct RandomCopies {
  std::string text;
  int n = 0;
};
RandomCopies random_copies() {
  if (may()) return {kCopies, 6};
  if (may()) return {"M01\nR3M02X50.\nM08\n", 4};
  return {"M01\nM02X100.M80\nM08\n", 2};
}

/// The stored corrections taken in order, each for places of its own, without M25.
std::string random_replay(int label, int n_copies, bool is_single) {
  std::string text = fmt::format("M51,{}\n", label);
  for (int n = *rc::gen::inRange(1, n_copies + 1); n > 0; --n) {
    text += is_single ? "M52\n" : may() ? "M52,3\n" : "M52\nM52\nM52\n";
    if (may()) text += random_holes();
  }
  return text + random_holes() + "G47\n";
}

/// Nested series that are not stored, in the program itself or in a pattern.
std::string random_nested(const std::string& copies) {
  std::string text = may() ? "G47\n" : "";
  if (may()) return text + kTargets + random_holes() + (may() ? "G47\n" : "") + random_holes();
  text += "M25\n";
  text += may() ? "G47\n" : may() ? random_holes() : "";
  text += kTargets + random_holes();
  if (may()) text += "G47\n" + random_holes();
  return text + copies;
}

/// Boards stored once or twice and used several times, with cancellations, holes and nested series
/// between.
std::string random_stored_job() {
  std::string text = "T1\n";
  if (may()) text += kBoard;
  const RandomCopies copies = random_copies();
  const char* const level = may() ? "G46" : "G36";
  const bool is_nested = level == std::string("G46");
  const int n_labels = *rc::gen::inRange(1, 3);
  for (int label = 1; label <= n_labels; ++label) {
    const bool is_single = *rc::gen::inRange(0, 4) == 0;
    if (*rc::gen::inRange(0, 3) == 0) text += random_nested(copies.text) + "G47\n";
    text += fmt::format("M50,{}\nM25\n", label);
    if (may()) text += (!is_nested && may() ? "G47\n" : "") + random_holes();
    if (is_single) {
      text += is_nested ? "G45X5.Y5.\n" : "G35X5.Y5.\n";
    } else {
      text += fmt::format("{0}X5.Y5.\n{0}X45.Y5.\n{0}X5.Y45.\n", level);
    }
    if (may()) text += random_holes();
    if (is_single || may()) text += "G47\n";
    text += copies.text;
    for (int n = *rc::gen::inRange(0, 4); n > 0; --n) {
      if (may()) text += may() ? "T1\n" : "T2\n";
      if (may()) text += "X1.Y1.\n";
      if (*rc::gen::inRange(0, 3) == 0) text += random_replay(label, copies.n, is_single);
      text += fmt::format("M51,{}\nM25\nM52{}\n", label, is_single ? "" : ",3") + random_holes();
      if (is_single || may()) text += "G47\n";
      if (!is_single && may()) text += random_holes();
      text += copies.text;
      if (may()) text += "M25\n" + random_holes() + copies.text;
      if (is_nested && *rc::gen::inRange(0, 3) == 0) text += random_nested(copies.text);
    }
  }
  return excellon_boards(text + "G37\nX1.Y1.\n");
}

RC_GTEST_PROP(StoredTranslation, DrillsTheSameHolesAtTheSamePlaces, ()) {
  const std::string text = random_stored_job();
  FunctionSource panel = small_boards();
  const WorkRun before = run_on(panel, text);
  RC_LOG(text);
  if (!before.errors.empty()) RC_LOG(before.errors.front());
  RC_ASSERT(before.errors.empty());
  const Translation translation = translate(text, Dialect::SiebMeyer);
  RC_LOG(translation.text);
  RC_ASSERT(translation.errors.empty());
  RC_ASSERT(translation.losses.empty());
  const WorkRun after = run_on(panel, translation.text);
  if (!after.errors.empty()) RC_LOG(after.errors.front());
  RC_ASSERT(after.errors.empty());
  const double worst_um = distance_um(before, after);
  RC_ASSERT(worst_um >= 0);
  RC_ASSERT(worst_um < kSameOnPanel_um);
}

RC_GTEST_PROP(StoredTranslation, ExcellonKeepsItsOwn, ()) {
  const std::string text = random_stored_job();
  const Translation same = translate(text, Dialect::Excellon);
  RC_LOG(same.text);
  RC_ASSERT(same.errors.empty());
  RC_ASSERT(same.losses.empty());
  FunctionSource panel = small_boards();
  const WorkRun after = run_on(panel, same.text);
  RC_ASSERT(after.errors.empty());
  RC_ASSERT(difference_of_work(run_on(panel, text), after).empty());
}

}  // namespace
}  // namespace panelcal
