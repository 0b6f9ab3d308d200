// SPDX-License-Identifier: Apache-2.0
// Corrections that copies keep for later patterns, in both languages: M50, M51 and M52; G39,SAVE
// and G39,LOAD. Run on the same panel, source and translation drill the same holes.
#include <cmath>
#include <set>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/program/program_run.h"
#include "tests/program/writers/translation/run.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::difference_of_work;
using test::FunctionSource;
using test::run_on;
using test::translate;
using test::Translation;
using test::WorkRun;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A panel that lies turned and stretched, with boards that lie on it each in its own way.
FunctionSource panel_of_boards(const Vector2d& pitch_mm, const Vector2d& first_mm) {
  return FunctionSource([=](const MeasurementRequest& request) -> Vector2d {
    const Vector2d p = request.nominal.in_mm();
    const Vector2d board((p - first_mm).cwiseQuotient(pitch_mm).array().floor());
    const double k = board.x() + 3 * board.y();
    const double angle_rad = 0.0003 * std::sin(1 + 2 * k);
    const Vector2d in_board = p - first_mm - board.cwiseProduct(pitch_mm);
    const Vector2d moved = p + angle_rad * Vector2d(-in_board.y(), in_board.x()) +
                           0.04 * Vector2d(std::cos(k), std::sin(3 * k));
    return {1.0003 * moved.x() - 0.002 * moved.y() + 0.4,
            0.002 * moved.x() + 0.9998 * moved.y() - 0.2};
  });
}

std::string excellon(const std::string& body) {
  return "M48\nMETRIC,LZ\nT1C1.0\nT2C2.0\n%\nG34,1\n" + body + "M30\n";
}
std::string sieb_meyer(const std::string& body) {
  return "%%5000\n" + body + "$\nT1D1.\nT2D2.\n$\n";
}

Dialect other(const std::string& text) {
  return text.starts_with("%%") ? Dialect::Excellon : Dialect::SiebMeyer;
}

/// Holes of two runs at the same places, in the same order, by the same tools; the largest distance
/// of two in um, negative if they are not the same holes.
double distance_um(const WorkRun& a, const WorkRun& b) {
  std::vector<Drill> holes[2];
  const WorkRun* runs[2] = {&a, &b};
  for (int i = 0; i < 2; ++i) {
    for (const test::Event& event : runs[i]->events) {
      if (const auto* drill = std::get_if<Drill>(&event.what)) holes[i].push_back(*drill);
    }
  }
  if (holes[0].size() != holes[1].size()) return -1;
  double worst_um = 0;
  for (std::size_t i = 0; i < holes[0].size(); ++i) {
    const Drill& from = holes[0][i];
    const Drill& to = holes[1][i];
    if (from.tool != to.tool || (from.nominal - to.nominal).in_mm().norm() > 1e-5) return -1;
    worst_um = std::max(worst_um, 1000 * (from.corrected - to.corrected).in_mm().norm());
  }
  return worst_um;
}

/// One fit from where targets are nominally, instead of two that follow each other, lacks a shear
/// that is the product of a turn and a difference of stretches: 2 mrad times 500 ppm here. Holes on
/// their own board are 50 mm from its targets, others (behind the pattern) as far as the panel
/// goes.
constexpr double kShear_um_per_mm = 1e3 * 0.002 * 500e-6;
constexpr double kSameOnBoard_um = 2 * kShear_um_per_mm * 50;
constexpr double kSameOnPanel_um = 2 * kShear_um_per_mm * 250;

FunctionSource small_boards() {
  return panel_of_boards({50, 50}, {0, 0});
}

std::string same_holes(const std::string& text,
                       double limit_um = kSameOnBoard_um,
                       FunctionSource panel = small_boards(),
                       const WalkOptions& options = {}) {
  const Translation translation = translate(text, other(text), options);
  EXPECT_THAT(translation.errors, IsEmpty());
  EXPECT_THAT(translation.losses, IsEmpty());
  const WorkRun before = run_on(panel, text, options);
  const WorkRun after = run_on(panel, translation.text, options);
  EXPECT_THAT(before.errors, IsEmpty());
  EXPECT_THAT(after.errors, IsEmpty()) << translation.text;
  EXPECT_FALSE(before.events.empty());
  const double worst_um = distance_um(before, after);
  EXPECT_GE(worst_um, 0) << translation.text;
  EXPECT_LT(worst_um, limit_um) << translation.text;
  return translation.text;
}

constexpr char kBoard[] = "G36X0.Y0.\nG36X190.Y0.\nG36X0.Y190.\n";
constexpr char kTargets[] = "G46X5.Y5.\nG46X45.Y5.\nG46X5.Y45.\n";
constexpr char kCopies[] = "M01\nR1M02X50.\nM01\nR2M02Y50.\nM08\n";
constexpr char kUse[] =
    "M51,1\nM25\nM52,3\nX10.Y20.\nX40.Y30.\nM01\nR1M02X50.\nM01\nR2M02Y50.\nM08\n";

// --- from Excellon -----------------------------------------------------------------------------

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
    return translate(excellon("$uvis,alg,0,2\nT1\n" + body), Dialect::SiebMeyer).errors;
  };
  const std::string series = "G36X5.Y5.\nG36X45.Y5.\n";
  EXPECT_THAT(
      errors_of("M50,1\n" + series + "X1.Y1.\n"),
      ElementsAre(test::Reports("p:11:1: error[not-supported]", "outside of such a pattern")));
  EXPECT_THAT(errors_of("M50,1\nM25\n" + series + "G46X5.Y5.\nG46X45.Y5.\nM01\nM08\n"),
              ElementsAre(test::Reports("p:14:1: error[not-supported]", "second series")));
  EXPECT_THAT(errors_of("M50,1\nM25\n" + series + "M01\nM08\nM51,1\nM52,2\nX1.Y1.\n"),
              ElementsAre(test::Reports("p:16:1: error[not-supported]", "\"M52,2\" outside")));
}

// --- from SIEB & MEYER -------------------------------------------------------------------------

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

TEST(StoredTranslation, RefusesLocationsByNumberAndOtherCopies) {
  const auto errors_of = [](const std::string& body) {
    return translate(sieb_meyer(body), Dialect::Excellon).errors;
  };
  EXPECT_THAT(errors_of("X5.Y5.G32\nG31\nG39,SAVE1\nX1.Y1.T1\n"),
              ElementsAre(test::Reports("p:4:1: error[not-supported]", "\"G39,SAVE1\"")));
  const Translation late =
      translate(sieb_meyer("M31\nX5.Y5.G32\nG31\nG39,SAVE\n" + std::string(kOffsets) +
                           "M31\nX9.Y9.T1\nG39,LOAD\nX1.Y1.\n" + kOffsets),
                Dialect::Excellon);
  EXPECT_TRUE(late.is_refused);
  EXPECT_THAT(late.losses, ElementsAre(HasSubstr("work ahead of G39,LOAD")));
}

/// A slot (mode 5) shows one coordinate; layers (2 and 3) are several looks.
TEST(StoredTranslation, RefusesSlotsAndLayers) {
  const auto errors_in_mode = [](int mode, const std::string& command) {
    WalkOptions options;
    options.sieb_meyer.measurement_mode = mode;
    const std::string text =
        sieb_meyer("X5.Y5." + command + "\nX45.Y5.G33\nX5.Y45.G33\nG31\nX1.Y1.T1\n");
    return translate(text, Dialect::Excellon, options).errors;
  };
  const auto named = [](const std::string& line) {
    return ElementsAre(
        test::Reports("p:" + line + ":1: error[not-supported]", "another mode than 1"));
  };
  for (const int mode : {2, 3, 5}) EXPECT_THAT(errors_in_mode(mode, "G32"), named("2"));
  for (const int mode : {1, 2, 3}) EXPECT_THAT(errors_in_mode(mode, "G33"), IsEmpty());
}

// --- random programs ---------------------------------------------------------------------------

std::string random_holes() {
  std::string text;
  for (int n = *rc::gen::inRange(1, 4); n > 0; --n) {
    text += fmt::format("X{}.Y{}.\n", *rc::gen::inRange(1, 49), *rc::gen::inRange(1, 49));
  }
  return text;
}

/// Boards stored once or twice and used several times, with cancellations and holes between.
std::string random_stored_job() {
  std::string text = "T1\n";
  const auto may = [] { return *rc::gen::arbitrary<bool>(); };
  if (may()) text += kBoard;
  const std::string copies = may()   ? kCopies
                             : may() ? "M01\nR3M02X50.\nM08\n"
                                     : "M01\nM02X100.M80\nM08\n";
  const char* const level = may() ? "G46" : "G36";
  const int n_labels = *rc::gen::inRange(1, 3);
  for (int label = 1; label <= n_labels; ++label) {
    const bool is_single = *rc::gen::inRange(0, 4) == 0;
    text += fmt::format("M50,{}\nM25\n", label);
    if (may()) text += (level == std::string("G36") && may() ? "G47\n" : "") + random_holes();
    if (is_single) {
      text += level == std::string("G46") ? "G45X5.Y5.\n" : "G35X5.Y5.\n";
    } else {
      text += fmt::format("{0}X5.Y5.\n{0}X45.Y5.\n{0}X5.Y45.\n", level);
    }
    if (may()) text += random_holes();
    if (is_single || may()) text += "G47\n";
    text += copies;
    for (int n = *rc::gen::inRange(0, 4); n > 0; --n) {
      if (may()) text += may() ? "T1\n" : "T2\n";
      if (may()) text += "X1.Y1.\n";
      text += fmt::format("M51,{}\nM25\nM52{}\n", label, is_single ? "" : ",3") + random_holes();
      if (is_single || may()) text += "G47\n";
      if (!is_single && may()) text += random_holes();
      text += copies;
      if (may()) text += "M25\n" + random_holes() + copies;
    }
  }
  return excellon(text + "G37\nX1.Y1.\n");
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
