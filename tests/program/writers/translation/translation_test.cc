// SPDX-License-Identifier: Apache-2.0
// Programs of both languages and their translations, executed.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/program/writers/translation/run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::difference_of_work;
using test::FunctionSource;
using test::other_language;
using test::Reports;
using test::run_nominally;
using test::run_on;
using test::sieb_meyer;
using test::translate;
using test::Translation;
using test::work_of;
using test::WorkRun;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A panel that lies turned and is stretched unevenly, so that every correction is another one.
FunctionSource crooked_panel() {
  return FunctionSource([](const MeasurementRequest& request) -> Eigen::Vector2d {
    const Eigen::Vector2d p = request.nominal.in_mm();
    return {1.0002 * p.x() - 0.001 * p.y() + 0.3 + 2e-6 * p.x() * p.y(),
            0.001 * p.x() + 0.9999 * p.y() - 0.2 + 1e-6 * p.x() * p.x()};
  });
}

/// The translation, which has to do the same work and `n_losses` things less.
std::string same_work(const std::string& text, std::size_t n_losses = 0) {
  const Translation translation = translate(text, other_language(text));
  EXPECT_THAT(translation.errors, IsEmpty());
  EXPECT_FALSE(translation.is_refused);
  EXPECT_EQ(translation.losses.size(), n_losses) << testing::PrintToString(translation.losses);
  FunctionSource panel = crooked_panel();
  const WorkRun before = run_on(panel, text);
  const WorkRun after = run_on(panel, translation.text);
  EXPECT_THAT(before.errors, IsEmpty());
  EXPECT_THAT(after.errors, IsEmpty()) << translation.text;
  EXPECT_FALSE(work_of(before.events).empty());
  EXPECT_EQ(difference_of_work(before, after), "") << translation.text;
  return translation.text;
}

std::string excellon(const std::string& body) {
  return "M48\nMETRIC,LZ\nT1C1.0\nT2C2.0\nCP,1,1.0\nCP,2,2.0\n%\n" + body + "M30\n";
}

// --- from Excellon -----------------------------------------------------------------------------

TEST(Translation, PatternsOfTwoLevelsBecomeOneSection) {
  const std::string text =
      same_work(excellon("T1\nX90.\nM25\nX1.Y2.\nX3.Y4.\nM01\nR2M02X10.\n"
                         "R1M02X5.Y7.M70M80\nM01\nM02Y50.M90\nM08\nX80.Y0.\n"));
  // 4 copies of the inner level, executed again by the outer one, which mirrors y.
  EXPECT_THAT(text,
              HasSubstr("M31\nX1.Y2.\nX3.Y4.\nX0.Y0.M50\nX10.Y0.M50\nX20.Y0.M50\nX25.Y7.M60M90\n"
                        "X0.Y50.M80\nX10.Y50.M80\nX20.Y50.M80\nX25.Y43.M60M70M30\nX80.Y0.\n"));
}

TEST(Translation, CopiesThatTakeToolsAreExecuted) {
  EXPECT_THAT(same_work(excellon("T1\nM25\nX1.Y2.\nM01\nM02X10.T2\nM08\n")),
              testing::Not(HasSubstr("M31")));
}

TEST(Translation, APatternWhoseCopiesBeginWithAnotherToolIsExecuted) {
  EXPECT_THAT(same_work(excellon("T1\nM25\nX1.Y2.\nT2\nX3.Y4.\nM01\nM02X10.\nM08\n")),
              testing::Not(HasSubstr("M31")));
  EXPECT_THAT(same_work(excellon("M25\nT1\nX1.Y2.\nT2\nX3.Y4.\nM01\nM02X10.\nM08\n")),
              HasSubstr("M31\nX1.Y2.T1\nX3.Y4.T2\n"));
}

TEST(Translation, ContoursUnderAMirrorKeepTheirSide) {
  same_work(
      excellon("T2\nM25\nG00X10.Y10.\nG41\nM15\nG01X20.\nG02X30.Y20.I-10.J0.\nM17\nG05\n"
               "M01\nM02X100.M80\nM02Y100.M70\nM08\n"));
}

TEST(Translation, BoardCorrectionsOfOneTwoAndThreeTargets) {
  for (const std::string targets : {"G35X5.Y5.\n",
                                    "$uvis,alg,0,2\nG36X5.Y5.\nG36X95.Y5.\n",
                                    "$uvis,alg,0,3\nG36X5.Y5.\nG36X95.Y5.\nG36X5.Y95.\n"}) {
    same_work(excellon("G34,1\n" + targets + "T1\nX10.Y20.\nX90.Y80.\nG37\nX50.Y50.\n"));
  }
}

TEST(Translation, MeasuresEveryCopy) {
  const std::string pattern = "G36X5.Y5.\nG36X25.Y5.\nX10.Y20.\nX20.Y30.\nG38X7.Y7.\n";
  same_work(
      excellon("$uvis,alg,0,2\nG34,1\nT1\nM25\n" + pattern + "M01\nM02X100.\nM08\nG37\nX1.Y1.\n"));
}

TEST(Translation, ANestedTargetIsThePatternsOffset) {
  same_work(
      excellon("$uvis,alg,0,2\nG34,1\nT1\nG36X5.Y5.\nG36X95.Y5.\nM25\nG45X5.Y5.\nX10.Y20.\n"
               "G47\nM01\nM02X50.\nM08\nX1.Y1.\n"));
}

TEST(Translation, RefusesWhatWouldGoElsewhere) {
  const Translation nested =
      translate(excellon("G34,1\nT1\nG36X5.Y5.\nG36X95.Y5.\nG36X5.Y95.\n$uvis,alg,0,2\nG46X5.Y5.\n"
                         "G46X95.Y5.\nX1.Y1.\n"),
                Dialect::SiebMeyer);
  EXPECT_TRUE(nested.is_refused);
  EXPECT_THAT(nested.losses, ElementsAre(HasSubstr("2 targets")));
}

TEST(Translation, AnInchProgramIsGoodToTenNanometers) {
  const std::string text = same_work("M48\nINCH,TZ\nT1C.0394\n%\nT1\nX12345Y-67891\nX1Y1\nM30\n");
  EXPECT_THAT(text, HasSubstr("\nX31.3563Y-172.44314T1\nX0.00254Y0.00254\n"));
}

TEST(Translation, AxisVersionsRemain) {
  for (const char version : {'2', '5', '8'}) {
    same_work("M48\nMETRIC,LZ\nVER," + std::string(1, version) +
              "\nT2C2.0\nCP,2,2.0\n%\nT2\nM25\nX1.Y2.\nG00X10.Y10.\nG42\nM15\nG01X20.\n"
              "G03X30.Y20.I0.J-10.\nM17\nG05\nM01\nM02X50.M80M70\nM08\nM30\n");
  }
}

TEST(Translation, ZerosRemain) {
  WalkOptions options;
  options.work_zero = position_mm<frame::Machine>(7, 8);
  const std::string text = excellon("G93X10.Y20.\nT1\nX1.Y2.\n");
  // The translation counts from absolute zero: 7 + 10 and 8 + 20.
  const Translation there = translate(text, Dialect::SiebMeyer, options);
  EXPECT_THAT(there.text, HasSubstr("\nM49,FAX17.Y28.\n"));
  const WorkRun before = run_nominally(text, options);
  const WorkRun after = run_nominally(there.text, options);
  ASSERT_FALSE(work_of(after.events).empty());
  const auto actual_mm = [](const WorkRun& run) {
    return std::get<Drill>(work_of(run.events).back().what).actual.in_mm();
  };
  EXPECT_EQ(actual_mm(before), Eigen::Vector2d(18, 30));
  EXPECT_EQ(actual_mm(after), Eigen::Vector2d(18, 30));
}

// --- from SIEB & MEYER -------------------------------------------------------------------------

/// The manual's examples of the eight offset commands, a contour under each.
TEST(Translation, EveryOffsetCommandHasAForm) {
  for (const std::string command :
       {"M50", "M60", "M70", "M80", "M90", "M60M70", "M60M80", "M60M90"}) {
    const std::string text = same_work(
        sieb_meyer("X10.Y30.T2T0M31\nX10.Y40.G1G41F1.2\nX20.Y40.\nX20.Y10.G2I0.J15.\nX10.Y10.G1\n"
                   "X10.Y10.T0\nX12.Y13.\nX60.Y60." +
                   command + "\nX90.Y10." + command + "M30\n"));
    EXPECT_THAT(text, HasSubstr("M02X30.0Y-50.0\nM02\nM08\n"));
  }
}

TEST(Translation, RowsOfCopiesBecomeARepeat) {
  EXPECT_THAT(same_work(sieb_meyer("X1.Y2.T1M31M31\nX3.Y4.\nX0Y0M50V2\nX440.YM50W5M30\n"
                                   "X10.Y10.M50\nX10.Y210.M50M30\n")),
              HasSubstr("R4M02X110.0Y0.0\n"));
}

TEST(Translation, ASectionAtOnePlaceNeedsNoRepeat) {
  const std::string text = same_work(sieb_meyer("X1.Y2.T1M31\nX3.Y4.\nX100.Y200.M60M30\nX9.Y9.\n"));
  EXPECT_THAT(text, HasSubstr("T1\nX98.0Y201.0\nX96.0Y203.0\nX9.0Y9.0\n"));
}

TEST(Translation, ToolsOfTheirOwnInSectionsRemain) {
  same_work(
      sieb_meyer("X10.Y30.T1M31M31\nX30.Y40.M50\nX70.Y20.M50M30\nX10.Y30.T2M31\nX5.Y5.\n"
                 "X30.Y40.M50\nX70.Y20.M50M30\nX123.45Y234.67M50M30\n"));
}

TEST(Translation, FiguresArcsAndRoundEdges) {
  same_work(
      sieb_meyer("X30.Y50.T0T2\nX40.Y50.G2R15.F1.2\nX50.Y50.R-15.\nX60.Y50.G3\nX60.Y50.T0\n"
                 "X35.Y90.T0\nX35.Y90.G46R20.\nX35.Y90.T0\n"
                 "X90.Y90.T0\nX90.Y90.G49I30.J20.\nX90.Y90.T0\n"
                 "X10.Y10.T0\nX50.Y10.G1D5.\nX50.Y40.\nX50.Y40.T0\n"));
}

TEST(Translation, DrilledPatternsTextsAndSlots) {
  same_work(
      sieb_meyer("X0.Y0.V2T1\nX40.Y0.W5\nX50.Y50.G84R5.\nX10.Y80.M97,ABC\n"
                 "X10.Y10.G85\nX20.Y10.\n"));
}

TEST(Translation, BoardAndPatternMeasurements) {
  same_work(
      sieb_meyer("X5.Y5.G32\nX95.Y5.G32\nG31\nX10.Y10.T1M31\nX20.Y20.\nX0Y0M50\n"
                 "X50.Y0M50M30\nG34\nX1.Y1.\n"));
  same_work(
      sieb_meyer("M49,CAMA\nX5.Y5.G32\nX95.Y5.G32\nX5.Y95.G32\nG31\nM31\nX5.Y6.G36\n"
                 "X10.Y10.T1\nX0Y0M50\nX50.Y0M70M30\nX1.Y1.\n"));
  same_work(sieb_meyer("X10.Y10.T1M31\nX12.Y12.G36\nX0Y0M50\nX50.Y0M50M30\nX1.Y1.\n"));
}

/// A line that repeats a pattern is executed, so that the pattern comes twice.
TEST(Translation, ThePatternsOffsetEndsWithEachCopy) {
  const std::string text = same_work(
      sieb_meyer("M49,CAMA\nM31M31\nX5.Y6.G36\nX10.Y10.T1\nX0Y0M50\nX50.Y0M50M30\nX7.Y7.\n"
                 "X0Y0M50\nX0Y60.M50M30\nX1.Y1.\n"));
  EXPECT_THAT(text, HasSubstr("G45X5.0Y6.0\nT1\nX10.0Y10.0\nG47\nM01\n"));
}

TEST(Translation, SectionsWhoseCopiesBeginWithAnotherToolAreExecuted) {
  EXPECT_THAT(same_work(sieb_meyer("X1.Y1.T1\nX2.Y2.M31\nX3.Y3.T2\nX0Y0M50\nX50.Y0M50M30\n")),
              testing::Not(HasSubstr("M25")));
}

/// Scale and rotation act on the places of the copies as well, so these are no pattern.
TEST(Translation, SectionsThatScaleOrTurnThemselvesAreExecuted) {
  const std::string copies = "X0Y0M50\nX200.Y0M50M30\nX9.Y9.\n";
  EXPECT_THAT(same_work(sieb_meyer("M31\nM49,SAX1000.Y0\nX100.Y0T1M93\n" + copies)),
              HasSubstr("X100.1Y0.0\nX300.3Y0.0\n"));
  EXPECT_THAT(same_work(sieb_meyer("M31\n(TURN)\nM31\nM49,RA90.\nM30\nX100.Y0T1\n" + copies)),
              HasSubstr("X0.0Y100.0\nX0.0Y300.0\n"));
  // Nothing to end: the pattern remains one.
  EXPECT_THAT(same_work(sieb_meyer("M31\nM49,NOSA\nM49,NORA\nX100.Y0T1\n" + copies)),
              HasSubstr("M25"));
}

TEST(Translation, NamesWhatSiebMeyerHasAlone) {
  const Translation there = translate(
      sieb_meyer("M34\nX1.Y1.T1\nM20\nG89I1.J.5\nM47,&P!TURN BOARD\nM47,SOMETHING THAT IS LONGER\n"
                 "X2.Y2.\n"),
      Dialect::Excellon);
  EXPECT_FALSE(there.is_refused);
  EXPECT_EQ(there.losses.size(), 3U) << testing::PrintToString(there.losses);
  EXPECT_THAT(there.text,
              HasSubstr("T1\nX1.0Y1.0\nM06\nM47,TURN BOARD\nM45,SOMETHING THAT IS LONGER\n"
                        "X2.0Y2.0\nM30\n"));
}

TEST(Translation, RefusesWorkingPlanes) {
  const Translation there =
      translate(sieb_meyer("X1.Y1.T1Z1.5\nX2.Y2.\nX3.Y3.G83K.4\n"), Dialect::Excellon);
  EXPECT_TRUE(there.is_refused);
  EXPECT_THAT(there.losses,
              ElementsAre(Reports("p:2: error[translation-refused]", "Z1.5"),
                          Reports("p:3: error[translation-refused]", "Z1.5"),
                          Reports("p:4: error[translation-refused]", "0.4 mm")));
}

TEST(Translation, RefusesAnOffsetFromTwoTargets) {
  const Translation there = translate(
      sieb_meyer("M49,CAMA\nM31\nX5.Y6.G36\nX15.Y6.G36\nX10.Y10.T1\nX0Y0M50\nX50.Y0M50M30\n"),
      Dialect::Excellon);
  EXPECT_TRUE(there.is_refused);
}

}  // namespace
}  // namespace panelcal
