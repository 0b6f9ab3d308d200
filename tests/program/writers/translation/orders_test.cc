// SPDX-License-Identifier: Apache-2.0
// A SIEB & MEYER program in its own language: orders of optical measurement and of surface
// detection go on as they are, so that the control measures, probes and works as before.
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/program/writers/translation/boards.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::asks_alike;
using test::BulgingBoard;
using test::difference_of_work;
using test::FunctionSource;
using test::Reports;
using test::run_on;
using test::same_orders;
using test::sieb_meyer;
using test::small_boards;
using test::translate;
using test::Translation;
using test::WorkRun;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// --- optical measurement (9) -------------------------------------------------------------------

constexpr char kThreeTargets[] = "X0.Y0.G32\nX190.Y0.G32\nX0.Y190.G32\nG31\n";

TEST(OwnOrders, CorrectionsAreTurnedOffAndOnAgain) {
  const std::string text =
      same_orders(sieb_meyer(std::string(kThreeTargets) + "X1.Y2.T1\nG30\nX3.Y4.\nG31\nX5.Y6.\n" +
                             kThreeTargets + "X7.Y8.\nG34\nX9.Y9.\n"));
  EXPECT_THAT(text,
              HasSubstr("X1.Y2.T1\nG30\nX3.Y4.\nG31\nX5.Y6.\nX0.Y0.G32\nX190.Y0.G32\nX0.Y190.G32\n"
                        "G31\nX7.Y8.\nG34\nX9.Y9.\n"));
}

TEST(OwnOrders, SetsKeepTheirLocations) {
  const std::string text = same_orders(sieb_meyer(
      std::string(kThreeTargets) +
      "G39,SAVE1000\nM31\nG39,LOAD1000\nX5.Y5.G32\nX45.Y45.G32\nG31\nG39,SAVE\nX7.Y7.T1\nX0.Y0."
      "M50\n"
      "X50.Y0.M50M30\nM31\nG39,LOAD\nX10.Y20.\nX0.Y0.M50\nX50.Y0.M50M30\nG39,LOAD2\nX60.Y30.\n"
      "G39,CLEAR2\nG39,LOAD1000\nX1.Y1.\nG39,DELALL\nX2.Y2.\n"));
  EXPECT_THAT(text,
              HasSubstr("G39,SAVE1000\nM31\nG39,LOAD1000\nX5.Y5.G32\nX45.Y45.G32\nG31\n"
                        "G39,SAVE\nX7.Y7.T1\nX0.Y0.M50\n"));
  EXPECT_THAT(text, HasSubstr("G39,CLEAR2\nG39,LOAD1000\nX1.Y1.\nG39,DELALL\n"));
}

/// The number of a copy counts through the levels, of which a translation keeps the innermost.
TEST(OwnOrders, LocationsOfSectionsInSectionsAreNumbered) {
  const std::string offsets = "X0.Y0.M50\nX50.Y0.M50M30\nX0.Y0.M50\nX0.Y50.M50M30\n";
  const std::string text =
      same_orders(sieb_meyer("M31M31\nG34\nX5.Y5.G32\nX45.Y45.G32\nG31\nG39,SAVE\nX7.Y7.T1\n" +
                             offsets + "M31M31\nG39,LOAD\nX10.Y20.\n" + offsets));
  EXPECT_THAT(text, HasSubstr("G31\nG39,SAVE4\nX57.Y57.\n"));
  EXPECT_THAT(text, HasSubstr("G39,LOAD4\nX60.Y70.\n"));
}

TEST(OwnOrders, SlotsAndLayersKeepTheirMode) {
  const auto in_mode = [](int mode, const std::string& targets) {
    WalkOptions options;
    options.sieb_meyer.measurement_mode = mode;
    return same_orders(sieb_meyer(targets + "G31\nX10.Y20.T1\nX30.Y40.\n"), options);
  };
  const std::string layers =
      "X5.Y5.G32\nX5.Y5.G33\nX45.Y5.G33\nX5.Y45.G32\nX5.Y46.G32\nX5.Y45.G33\n";
  EXPECT_THAT(in_mode(2, layers), HasSubstr('\n' + layers + "G31\n"));
  EXPECT_THAT(in_mode(3, layers), HasSubstr('\n' + layers + "G31\n"));
  const std::string slots = "X5.Y5.G33\nX25.Y5.G32\nX5.Y45.G33\nX45.Y25.G32\n";
  EXPECT_THAT(in_mode(5, slots), HasSubstr('\n' + slots + "G31\n"));
}

/// Also where the camera computer's values are in force already.
TEST(OwnOrders, RequestsAreLeftToTheCameraComputer) {
  WalkOptions options;
  options.sieb_meyer.measurement_mode = 3;
  const std::string body =
      "X0.Y0.G32\nX0.Y0.G33\nX190.Y0.G33\nG39,REQCOMP\nX1.Y1.T1\nG30\nX2.Y2.\nG39,REQCOMP\nG31\n"
      "G39,REQCOMP\nX3.Y3.\n";
  EXPECT_THAT(same_orders(sieb_meyer(body), options), HasSubstr('\n' + body));
}

TEST(OwnOrders, PatternsAreMeasuredAtTwoTargets) {
  const std::string text =
      same_orders(sieb_meyer(std::string(kThreeTargets) +
                             "M49,CAMA\nM31\nX5.Y5.G36\nX45.Y5.G36\nX10.Y20.T1\nX0.Y0.M50\n"
                             "X50.Y0.M70M30\nM49,NOCAMA\nX30.Y30.G36\nX1.Y1.\n"));
  EXPECT_THAT(text, HasSubstr("M31\nM49,CAMA\nX5.Y5.G36\nX45.Y5.G36\nX10.Y20.T1\n"));
  EXPECT_THAT(text, HasSubstr("M49,NOCAMA\nX30.Y30.G36\nX1.Y1.\n"));
}

/// Outside of sections nothing would end an offset behind a copy.
TEST(OwnOrders, RefusesOffsetsOfCopiesThatAreWrittenOut) {
  const std::string offsets = "X0.Y0.M50\nX50.Y0.M50M30\n";
  const std::string section = "X1.Y1.T1\nM31\nX5.Y5.G36\nX2.Y2.\nX3.Y3.T2\n" + offsets;
  const Translation lost =
      translate(sieb_meyer("M49,CAMA\n" + section + "X4.Y4.\n"), Dialect::SiebMeyer);
  EXPECT_THAT(lost.losses,
              ElementsAre(Reports("p:5: error[translation-refused]",
                                  "\"G36\", whose effect ends with a copy")));
  const Translation cleared =
      translate(sieb_meyer("M49,CAMA\nX5.Y5.G36\nX1.Y1.T1\nM31\nX2.Y2.\nG34\nX3.Y3.T2\n" + offsets +
                           "X5.Y45.G36\nX4.Y4.\n"),
                Dialect::SiebMeyer);
  EXPECT_THAT(cleared.losses,
              ElementsAre(Reports("p:7: error[translation-refused]",
                                  "\"G34\", whose effect ends with a copy")));
}

/// A control stores the offset of its spindle, whatever panelcal knows of it.
TEST(OwnOrders, SpindlesAreCorrectedByTheControl) {
  const Translation same = translate(
      sieb_meyer("X5.Y5.T1\nX5.Y5.G32\nG39,SPOP1\nG39,SPISPI\nX9.Y9.\n"), Dialect::SiebMeyer);
  EXPECT_THAT(same.errors, IsEmpty());
  EXPECT_THAT(same.losses, IsEmpty());
  EXPECT_THAT(same.text, HasSubstr("X5.Y5.T1\nX5.Y5.G32\nG39,SPOP1\nG39,SPISPI\nX9.Y9.\n"));
}

// --- surface detection (10) --------------------------------------------------------------------

/// SIEB & MEYER CNC 8x.00 Command Set, 10.1, Example: Measurement.
TEST(OwnOrders, TheManualsExampleOfSurfaceDetection) {
  const std::string text = same_orders(sieb_meyer(
      "G71\nX165.Y15.G73L1\nG75\nX110.Y10.G73L2\nG75\nG71K.4\nL1\nX165.Y15.T1\nX170.Y15.\nG71K.5\n"
      "L2\nX110.Y10.T0T2\nX110.Y30.G1F1.5\nX110.Y30.T0\nG70\nX1.Y1.\n"));
  EXPECT_THAT(text,
              HasSubstr("G71\nX165.Y15.G73L1\nG75\nX110.Y10.G73L2\nG75\nG71K0.4\nL1\n"
                        "X165.Y15.T1\nX170.Y15.\nG71K0.5\nL2\nX110.Y10.T2T0\n"));
  EXPECT_THAT(text, HasSubstr("X110.Y30.T0\nG70\n"));
}

TEST(OwnOrders, AveragesAndRecordsArePassedOn) {
  const std::string text = same_orders(sieb_meyer(
      "M49,SPAV,M\nG71\nX10.Y12.G73\nG73L101\nX40.Y30.G73\nX20.Y22.G73\nG74L1\nX5.Y5.G76\nG72\n"
      "X30.Y30.G73L2\nG71K.4\nL2\nX65.Y15.T1\nX17.Y15.T2G77Z.5\nX20.Y20.\nG82\nX21.Y21.\nG70\n"));
  EXPECT_THAT(text,
              HasSubstr("M49,SPAV,M\nG71\nX10.Y12.G73\nG73L101\nX40.Y30.G73\nX20.Y22.G73\nG74L1\n"
                        "X5.Y5.G76\nG72\nX30.Y30.G73L2\nG71K0.4\nL2\nX65.Y15.T1\n"));
}

/// CNC commands "remain active after the execution is finished" (M49): the job before may have left
/// another average than that of the source or of [surface] average.
TEST(OwnOrders, TheAverageIsStatedAheadOfG74) {
  const std::string probes = "G71\nX10.Y12.G73\nX20.Y22.G73\nX30.Y22.G73\n";
  const std::string holes = "L1\nG71K.4\nX65.Y15.T1\nG70\n";
  EXPECT_THAT(same_orders(sieb_meyer(probes + "G74L1\n" + holes)),
              HasSubstr(probes + "M49,SPAV,A\nG74L1\n"));
  WalkOptions options;
  options.sieb_meyer.average = AverageKind::TrimmedMean;
  EXPECT_THAT(same_orders(sieb_meyer(probes + "G74L1\n" + holes), options),
              HasSubstr(probes + "M49,SPAV,T\nG74L1\n"));
  const std::string again = same_orders(
      sieb_meyer(probes + "G74L1\nX40.Y5.G73\nG74L2\nM49,SPAV,M\nX40.Y9.G73\nG74L3\n" + holes));
  EXPECT_THAT(again,
              HasSubstr("M49,SPAV,A\nG74L1\nX40.Y5.G73\nG74L2\nM49,SPAV,M\nX40.Y9.G73\nG74L3\n"));
  // A copy begins as the one before it ended.
  const std::string pattern = same_orders(
      sieb_meyer("M49,SPAV,M\nM31\nG71K.4\nX5.Y5.T1G73L2\nX10.Y12.G73\nX20.Y22.G73\nG74L1\nL1\n"
                 "X65.Y15.\nG70\nX0.Y0.M50\nX90.Y0.M50M30\n"));
  EXPECT_THAT(pattern, HasSubstr("M49,SPAV,M\nM31\n"));
  EXPECT_THAT(pattern, HasSubstr("M49,SPAV,M\nG74L1\n"));
}

/// "If surface detection is programmed with Step-and-Repeat, it has to be activated and
/// deactivated" (10.1).
TEST(OwnOrders, SurfacesAreProbedInEveryCopy) {
  const std::string offsets = "X0.Y0.M50\nX50.Y0.M50\nX90.Y40.M90M30\n";
  const std::string text =
      same_orders(sieb_meyer("M31\nG71K.4\nX5.Y5.T1G73L1\nX10.Y10.\nX20.Y10.T2T0\nX20.Y30.G1F1.\n"
                             "X20.Y30.T0\nG70\n" +
                             offsets +
                             "X12.Y13.G82Z1.\nM31\nG71K.3\nL1\n"
                             "X9.Y9.\nX7.Y7.G77\nG70\nX6.Y5.G76\n" +
                             offsets));
  EXPECT_THAT(text, HasSubstr("M31\nG71K0.4\nX5.Y5.T1G73L1\nX10.Y10.\nX20.Y10.T2T0\n"));
  EXPECT_THAT(text, HasSubstr("X20.Y30.T0\nG70\nX0.Y0.M50\n"));
  EXPECT_THAT(text,
              HasSubstr("M31\nG71K0.3\nL1\nX9.Y9.Z1.\nG70\nX7.Y7.\nG71\nX6.Y5.G76\nG70\n"
                        "X0.Y0.M50\n"));
}

TEST(OwnOrders, SurfaceDetectionMayHoldRoundASection) {
  const std::string offsets = "X0.Y0.M50\nX50.Y0.M50M30\nX1.Y1.\nG70\nX2.Y2.\n";
  const std::string begin = "G71K.4\nX5.Y5.G73L1\nX9.Y9.T1\nM31\nX10.Y10.\n";
  const std::string text = same_orders(sieb_meyer(begin + offsets));
  EXPECT_THAT(text, HasSubstr("X9.Y9.T1\nM31\nX10.Y10.K0.4\nX0.Y0.M50\n"));
  const Translation lost =
      translate(sieb_meyer(begin + "X3.Y3.G77\n" + offsets), Dialect::SiebMeyer);
  EXPECT_THAT(lost.losses,
              ElementsAre(Reports("p:7: error[translation-refused]", "begins under G71")));
}

constexpr char kGrid[] =
    "M49,MAPT1.\nX10.Y5.T1G78\nX0Y0G79M31M31\nX0Y0M50V2\nX90.YM50W4M30\nX0Y0M50V2\nXY60.M50W3M30\n";

TEST(OwnOrders, TheControlMeasuresItsGrid) {
  const std::string text = same_orders(
      sieb_meyer(std::string(kGrid) +
                 "X10.Y20.Z1.T2\nX50.Y20.G85\nX58.Y20.\nX30.Y30.T0\nX80.Y30.G1F1.\n"
                 "X80.Y50.G6Z.8\nX80.Y50.T0\nM31\nX3.Y4.Z1.\nX20.Y0M50\nX40.Y0M50M30\n"));
  EXPECT_THAT(text,
              HasSubstr("M49,MAPT1.\nX10.Y5.T1G78\nM31\nX0.Y0.G79\nX0.Y0.M50\nX30.Y0.M50\n"
                        "X60.Y0.M50\nX90.Y0.M50M30\nM31\nX0.Y0.G79\nX0.Y30.M50\n"));
  EXPECT_THAT(text, HasSubstr("M30\nX10.Y20.T2Z1.\nX50.Y20.G85\nX58.Y20.\n"));
}

/// "Whether a through hole stroke or depth hole stroke is carried out during measurement is defined
/// by programming" (10.2, G79).
TEST(OwnOrders, GridsAreProbedByDepthStrokes) {
  const std::string text =
      same_orders(sieb_meyer("M49,BOTR1.5\nX0Y0T1G83K.2G79\nX60.Y0G79\nX0Y60.G79\n"
                             "X60.Y60.G79\nX20.Y20.G82Z1.\nX30.Y20.\n"));
  EXPECT_THAT(text, HasSubstr("X0.Y0.T1G79G83K0.2\nX60.Y0.G79\n"));
  EXPECT_THAT(text, HasSubstr("X20.Y20.G82Z1.\nX30.Y20.\n"));
}

TEST(OwnOrders, ALineMayTakeNoAccountOfTheGrid) {
  const std::string drilled = "X10.Y20.Z1.\nX20.Y20.T2Z.9G77\nX30.Y20.\n";
  EXPECT_THAT(same_orders(sieb_meyer(kGrid + drilled)),
              HasSubstr("X10.Y20.Z1.\nX20.Y20.T2G77Z0.9\nX30.Y20.\n"));
  const std::string routed = "X10.Y20.Z1.T0\nX20.Y20.G1F1.G77\nX20.Y20.T0\n";
  EXPECT_THAT(translate(sieb_meyer(kGrid + routed), Dialect::SiebMeyer).errors,
              ElementsAre(Reports("p:10:1: error[not-supported]", "\"X20.Y20.G1F1.G77\"")));
}

TEST(OwnOrders, ExcellonNamesSurfacesThatItCannotProbe) {
  const auto losses_of = [](const std::string& body) {
    return translate(sieb_meyer(body), Dialect::Excellon).losses;
  };
  EXPECT_THAT(losses_of("G71K.4\nX5.Y5.G73L1\nX1.Y1.T1\nG70\nX2.Y2.\n"),
              ElementsAre(Reports("p:3: warning[translation-loss]", "probing of the surface"),
                          Reports("p:4: error[translation-refused]", "0.4 mm below the board")));
  EXPECT_THAT(losses_of(std::string(kGrid) + "X1.Y1.\nX2.Y2.\n"),
              ElementsAre(Reports("p:2: warning[translation-loss]", "\"M49,MAPT1.\""),
                          Reports("p:3: error[translation-refused]", "a measured grid")));
}

// --- random programs ---------------------------------------------------------------------------

int any_of_range(int low, int high) {
  return *rc::gen::inRange(low, high + 1);
}

std::string any_place() {
  return fmt::format("X{}.Y{}.", any_of_range(1, 49), any_of_range(1, 49));
}

std::string any_depth() {
  return fmt::format("K.{}", any_of_range(1, 5));
}

/// Strokes under SLM, below a surface that was probed before or in place.
std::string any_slm_strokes() {
  std::string text = "G71" + any_depth() + '\n';
  text += any_of_range(0, 1) == 0 ? fmt::format("L{}\n", any_of_range(1, 3))
                                  : any_place() + fmt::format("T1G73L{}\n", any_of_range(1, 3));
  for (int n = any_of_range(1, 4); n > 0; --n) {
    switch (any_of_range(0, 5)) {
      case 0:
        text += any_place() + "T1G77\n";
        break;
      case 1:
        text += fmt::format("L{}\n", any_of_range(1, 3));
        break;
      case 2:
        text += "X10.Y10.T2T0\nX20.Y30.G1F1.\nX40.Y30.G2R15.\nX40.Y30.T0\n";
        break;
      case 3:
        text += "G71" + any_depth() + '\n';
        break;
      default:
        text += any_place() + fmt::format("T{}\n", any_of_range(1, 2));
        break;
    }
  }
  if (any_of_range(0, 3) == 0) text += "G82\n" + any_place() + "T1\n";
  return text + "G70\n";
}

std::string any_other_strokes() {
  switch (any_of_range(0, 3)) {
    case 0:
      return any_place() + "T1G83" + any_depth() + '\n' + any_place() + "G82\n";
    case 1:
      return any_place() + fmt::format("T2Z{}.\n", any_of_range(0, 1));
    case 2:
      return any_place() + "G76\n";
    default:
      return any_place() + "T1\n";
  }
}

/// Surfaces probed ahead, in sections and between, and strokes of every control of the Z axis.
std::string any_surface_job() {
  constexpr const char* kMoved[] = {"", "M49,RA90.\n", "M49,RA4.\n", "M49,SAX300.Y300.\nM93\n"};
  std::string text = kMoved[any_of_range(0, 3)] + any_place() + "Z1.T1\nG71\n";
  for (int i = 1; i <= 3; ++i) text += any_place() + fmt::format("G73L{}\n", i);
  if (any_of_range(0, 1) == 0) text += any_place() + "G73\n" + any_place() + "G73\nG74L2\nG75\n";
  text += "G70\n";
  for (int n = any_of_range(1, 5); n > 0; --n) {
    std::string part = any_of_range(0, 2) > 0 ? any_slm_strokes() : any_other_strokes();
    const std::string offsets = any_of_range(0, 1) == 0
                                    ? "X0.Y0.M50\nX60.Y0.M70\nX0.Y50.M50M30\n"
                                    : "X0.Y0.M50\nX60.Y0.M60\nX9.Y50.M60M80M30\n";
    if (any_of_range(0, 2) == 0) {
      part = "M31\n" + part + (any_of_range(0, 3) == 0 ? any_other_strokes() : "") + offsets;
    } else if (any_of_range(0, 4) == 0) {
      part = "G71" + any_depth() + "\nL2\nM31\n" + any_place() + "T1\n" + any_place() + "T2\n" +
             offsets + any_place() + "\nG70\n";
    }
    text += part;
  }
  return sieb_meyer(text + "X1.Y1.T1G82Z1.\n");
}

RC_GTEST_PROP(OwnOrders, SurfacesAreProbedAndUsedAsBefore, ()) {
  const std::string text = any_surface_job();
  RC_LOG(text);
  FunctionSource panel = small_boards();
  BulgingBoard board;
  const WorkRun before = run_on(panel, board, text);
  if (!before.errors.empty()) RC_LOG(before.errors.front());
  RC_ASSERT(before.errors.empty());
  const Translation same = translate(text, Dialect::SiebMeyer);
  RC_LOG(same.text);
  RC_ASSERT(same.errors.empty());
  RC_ASSERT(same.losses.empty());
  const WorkRun after = run_on(panel, board, same.text);
  if (!after.errors.empty()) RC_LOG(after.errors.front());
  RC_ASSERT(after.errors.empty());
  RC_ASSERT(asks_alike(before, after));
  const std::string difference = difference_of_work(before, after);
  RC_LOG(difference);
  RC_ASSERT(difference.empty());
}

}  // namespace
}  // namespace panelcal
