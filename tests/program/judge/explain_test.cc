// SPDX-License-Identifier: Apache-2.0
#include "program/judge/explain.h"

#include <string>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"

namespace panelcal {
namespace {

using test::FunctionSource;
using test::metric;

/// The panel lies turned as in a right triangle of sides 3, 4 and 5.
FunctionSource turned_panel() {
  return FunctionSource([](const MeasurementRequest& request) -> Eigen::Vector2d {
    const Eigen::Vector2d p_mm = request.expected.in_mm();
    return {0.8 * p_mm.x() - 0.6 * p_mm.y() + 1, 0.6 * p_mm.x() + 0.8 * p_mm.y() + 2};
  });
}

std::string explained(const std::string& text,
                      const std::string& choice,
                      MeasurementSource& source,
                      WalkOptions options = {}) {
  options.series_size = 2;
  DiagnosticLog log;
  Program program = load_program({"p.exc", text}, log);
  program.patterns.emplace("PINS", SourceText{"lib/PINS", "; two pins\nX0.Y0.\nX5.Y0.\n"});
  const Survey survey = panelcal::survey(program, options, source, log);
  EXPECT_FALSE(log.has_errors()) << log.kept().front().text();
  Explainer explainer(
      *parse_explain_choice(choice), program, survey, options.uncertainty, options.tolerances);
  execute(program, options, survey, explainer, log);
  return explainer.text();
}

std::string explained(const std::string& text,
                      const std::string& choice,
                      const WalkOptions& options = {}) {
  NominalSource source;
  return explained(text, choice, source, options);
}

TEST(ExplainChoice, IsALineOrANumber) {
  ASSERT_TRUE(parse_explain_choice("L14").has_value());
  EXPECT_EQ(parse_explain_choice("L14")->line, 14);
  ASSERT_TRUE(parse_explain_choice("5000000000").has_value());
  EXPECT_EQ(parse_explain_choice("5000000000")->number, 5'000'000'000);
  for (const char* bad : {"", "L", "0", "L0", "-1", "l14", "14L", "1.5", " 1", "L5000000000"}) {
    EXPECT_FALSE(parse_explain_choice(bad).has_value()) << bad;
  }
}

/// A copy whose axes are swapped holds one that is mirrored: (10, 5) goes to (-10 + 50, 5), then to
/// (5, 40 + 30). The sigmas are those of a shift, 1 um / sqrt(2), and of a turn about (50, 0),
/// 1 um / sqrt(2) / 50 mm, at a hole that is (-78, 29) mm from there on the turned panel.
TEST(Explainer, AHoleInANestedCopyUnderABaseCorrection) {
  FunctionSource source = turned_panel();
  WalkOptions options;
  options.work_zero = position_mm<frame::Machine>(200, 100);
  EXPECT_EQ(
      explained(metric("G34,1\nG36X0.Y0.\nG36X100.Y0.\nT1\nM25\nX10.Y5.\nM01\nM02X50.M80\nM01\n"
                       "M02Y30.M70\nM08\nM30\n"),
                "4",
                source,
                options),
      "drill 4: p.exc:11: X10.Y5.\n"
      "  tool        1, diameter 1.0000 mm, taken in line 9\n"
      "  programmed  (10.000000, 5.000000) mm\n"
      "  placement   path [1,1]: x' = 0 x +1 y +0.000000, y' = -1 x +0 y +80.000000\n"
      "  nominal     (5.000000, 70.000000) mm\n"
      "  base        rigid, measured from line 7, path []: x' = 0.8 x -0.6 y +1.000000, y' = 0.6 x "
      "+0.8 y +2.000000\n"
      "    G36 target 0: nominal (0.000000, 0.000000) mm, measured (1.000000, 2.000000) mm, "
      "residual "
      "(+0.000, +0.000) um\n"
      "    G36 target 1: nominal (100.000000, 0.000000) mm, measured (81.000000, 62.000000) mm, "
      "residual (+0.000, +0.000) um\n"
      "  corrected   (-37.000000, 61.000000) mm, sigma (0.817, 1.310) um of the fit only\n"
      "  budget                      sigma x     y um share %  common to\n"
      "    detector                    0.817    1.310   100.0  holes of one fit\n"
      "    total                       0.817    1.310   100.0\n"
      "    not stated: camera calibration, stage at the targets, table at the targets, "
      "spindle-camera offset, its drift, stage at the hole, table at the hole, drill wander\n"
      "  work zero   (200.000000, 100.000000) mm\n"
      "  machine     (163.000000, 161.000000) mm\n");
}

/// The nested target is found 1 mm right of where the base correction expects it.
TEST(Explainer, ANestedCorrectionStandsBehindTheBase) {
  FunctionSource source([](const MeasurementRequest& request) -> Eigen::Vector2d {
    return request.expected.in_mm() + Eigen::Vector2d(1, 0);
  });
  const std::string text =
      explained(metric("G34,1\nG35X0.Y0.\nG45X10.Y0.\nT1\nX10.Y5.\nM30\n"), "1", source);
  const std::string identity = "x' = 1 x +0 y +1.000000, y' = 0 x +1 y +0.000000\n";
  EXPECT_NE(text.find("  base        offset, measured from line 7, path []: " + identity +
                      "    G35 target 0: nominal (0.000000, 0.000000) mm, measured (1.000000, "
                      "0.000000) mm, residual (+0.000, +0.000) um\n"
                      "  nested      offset, measured from line 8, path []: " +
                      identity +
                      "    G45 target 1: nominal (10.000000, 0.000000) mm, measured (12.000000, "
                      "0.000000) mm, residual (+0.000, +0.000) um\n"
                      "  corrected   (12.000000, 5.000000) mm"),
            std::string::npos)
      << text;
}

TEST(Explainer, ReferenceScalingStandsBetween) {
  WalkOptions options;
  options.scaling = ReferenceScaling{.x = 1.001, .y = 0.999};
  const std::string text = explained(metric("T1\nM60\nX10.Y20.\nM30\n"), "1", options);
  EXPECT_NE(text.find("  nominal     (10.000000, 20.000000) mm\n"
                      "  scaling     x' = 1.001 x +0 y +0.000000, y' = 0 x +0.999 y +0.000000\n"
                      "  correction  none in force\n"
                      "  corrected   (10.010000, 19.980000) mm, sigma (0.000, 0.000) um\n"),
            std::string::npos)
      << text;
}

TEST(Explainer, NamesTheLineOfAStoredPattern) {
  const std::string text = explained(metric("T1\nM99,PINS\nX10.Y20.\nM30\n"), "2");
  EXPECT_EQ(text.find("drill 2: lib/PINS:3: X5.Y0.\n"), 0U) << text;
  EXPECT_NE(text.find("  programmed  (5.000000, 0.000000) mm\n"), std::string::npos) << text;
  EXPECT_NE(text.find("  nominal     (15.000000, 20.000000) mm\n"), std::string::npos) << text;
}

/// sigma 1 um in each axis: P(|e| > 2 um) = exp(-2).
TEST(Explainer, SaysHowLikelyTheToleranceIsBroken) {
  WalkOptions options;
  options.tolerances.tools.push_back({.number = 1, .position = um(2)});
  const std::string body = "X9.Y9.\nG34,1\nG35X0.Y0.\nT1\nX10.Y5.\nT2\nX20.Y5.\nM30\n";
  const std::string text = explained(metric("T1\n" + body), "2", options);
  EXPECT_NE(text.find("\n  tolerance   2 um, risk of breaking it no figure: stage repeatability, "
                      "table residual and drill wander not stated\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find(" um of the fit only\n"), std::string::npos) << text;
  options.uncertainty.states_stage = options.uncertainty.states_table = true;
  options.uncertainty.states_wander = true;
  const std::string stated = explained(metric("T1\n" + body), "2", options);
  EXPECT_NE(stated.find("\n  tolerance   2 um, risk of breaking it 0.14\n"), std::string::npos)
      << stated;
  options.tolerances.tools[0].position = um(20);
  const std::string untold = explained(metric("T1\n" + body), "2", options);
  EXPECT_NE(untold.find("risk of breaking it 0.001, and none below can be stated: an error of any "
                        "size of target 1 (G35 in line 9) would pass unnoticed and move this place "
                        "by 1 times as much\n"),
            std::string::npos)
      << untold;
  const std::string before = explained(metric("T1\n" + body), "1", options);
  EXPECT_NE(
      before.find("\n  tolerance   20 um, risk of breaking it not known without a correction\n"),
      std::string::npos)
      << before;
  const std::string not_asked = explained(metric("T1\n" + body), "3", options);
  EXPECT_EQ(not_asked.find("tolerance"), std::string::npos) << not_asked;
}

/// The number leads to the place again; a line of another file cannot be asked for.
TEST(PlaceNumber, IsTheOneThatExplainTakes) {
  const std::string text = metric("T1\nM99,PINS\nX10.Y20.\nM99,PINS\nX30.Y40.\nM30\n");
  DiagnosticLog log;
  Program program = load_program({"p.exc", text}, log);
  program.patterns.emplace("PINS", SourceText{"lib/PINS", "; two pins\nX0.Y0.\nX5.Y0.\n"});
  JobVerdict::WorstPlace place;
  place.line = 3;
  place.file = "lib/PINS";
  place.nominal = position_mm<frame::Nominal>(35., 40.);
  PlaceNumber finder(place);
  execute(program, {}, {}, finder, log);
  ASSERT_TRUE(finder.number());
  EXPECT_EQ(*finder.number(), 4);
  EXPECT_EQ(explained(text, "4").find("drill 4: lib/PINS:3: X5.Y0.\n"), 0U);
  EXPECT_TRUE(finder.is_of_its_line());
  place.nominal = position_mm<frame::Nominal>(36., 40.);
  PlaceNumber nothing(place);
  execute(program, {}, {}, nothing, log);
  EXPECT_FALSE(nothing.number());
}

/// M15 in line 8 drills nothing; the move before it took the tool there.
TEST(PlaceNumber, OfAToolThatGoesDownIsTheMoveBefore) {
  DiagnosticLog log;
  const Program program = load_program(
      {"p.exc", metric("T1\nG00X1.Y1.\nM15\nG01X9.\nX1.\nM17\nG05\nX1.Y1.\nM30\n")}, log);
  JobVerdict::WorstPlace place;
  place.line = 8;
  place.nominal = position_mm<frame::Nominal>(1., 1.);
  PlaceNumber finder(place);
  execute(program, {}, {}, finder, log);
  ASSERT_TRUE(finder.number());
  EXPECT_EQ(*finder.number(), 1);
  EXPECT_FALSE(finder.is_of_its_line());
}

TEST(Explainer, CountsMovesAndRoutsAsPlaces) {
  const std::string body = "T1\nG00X1.Y1.\nM15\nG01X9.\nM17\nG05\nX2.Y2.\nM30\n";
  EXPECT_EQ(explained(metric(body), "1").find("position 1: p.exc:7: G00X1.Y1.\n"), 0U);
  EXPECT_EQ(explained(metric(body), "2").find("rout 2: p.exc:9: G01X9.\n"), 0U);
  EXPECT_EQ(explained(metric(body), "3").find("drill 3: p.exc:12: X2.Y2.\n"), 0U);
}

TEST(Explainer, TellsEveryPlaceOfALineUpToTwenty) {
  const std::string text = explained(metric("T1\nX1.Y1.\nR24X1.\nM30\n"), "L8");
  EXPECT_NE(text.find("drill 2: p.exc:8: R24X1.\n"), std::string::npos);
  EXPECT_NE(text.find("\n\ndrill 21: p.exc:8: R24X1.\n"), std::string::npos);
  EXPECT_EQ(text.find("drill 22:"), std::string::npos);
  EXPECT_TRUE(text.ends_with("\n\nand 4 more places of this line\n"));
}

TEST(Explainer, SaysWhenThereIsNothingToExplain) {
  EXPECT_EQ(explained(metric("T1\nX1.Y1.\nM30\n"), "L6"), "line 6 drills and routs nothing\n");
  EXPECT_EQ(explained(metric("T1\nX1.Y1.\nM30\n"), "2"), "there is no place 2: the job has 1");
}

/// The perfect board's surface is where it is expected, 1.6 mm above the table.
TEST(Explainer, DepthsAndTheSurfacesTheyReferTo) {
  WalkOptions options;
  options.sieb_meyer.surface_height = mm(1.6);
  const std::string text =
      "%%5000\nX1.Y1.T1\nX2.Y2.Z.5\nX3.Y3.K.25G83\nG82\nG71K.4\nX9.Y9.G73L1\nL1\nX4.Y4.\nG70\n$"
      "\nT1D1.\n$\n";
  EXPECT_EQ(explained(text, "L2", options).find("depth"), std::string::npos);
  EXPECT_NE(explained(text, "L3", options).find("  depth       to 0.5000 mm above the table\n"),
            std::string::npos);
  EXPECT_NE(
      explained(text, "L4", options).find("  depth       0.2500 mm below the board's surface\n"),
      std::string::npos);
  EXPECT_NE(explained(text, "L9", options)
                .find("  depth       0.4000 mm below the board's surface, surface measured 1.6000 "
                      "mm above the table\n"),
            std::string::npos);
  EXPECT_NE(explained(text, "L4", options)
                .find("  limit       no lower than 0.5000 mm above the table\n"),
            std::string::npos);
  EXPECT_EQ(explained(text, "L3", options).find("  limit"), std::string::npos);
}

TEST(Explainer, TheDepthThatTheOperatorSets) {
  EXPECT_NE(
      explained("%%5000\nX1.Y1.T1G83\n$\nT1D1.\n$\n", "L2")
          .find("  depth       below the board's surface, as deep as the operator sets (no K#)\n"),
      std::string::npos);
}

/// Measurement mode 2: two layers make a point of the fit, which the last one names.
TEST(Explainer, AFitOfLayersHasAResidualForEachPoint) {
  WalkOptions options;
  options.sieb_meyer.measurement_mode = 2;
  const std::string text = explained(
      "%%5000\nX10.Y10.G32\nX10.Y10.G33\nX90.Y10.G32\nX90.Y10.G33\nG31\nX5.Y5.T1\n$\nT1D1.\n$\n",
      "L7",
      options);
  EXPECT_EQ(text.find("target 0:"), std::string::npos);
  EXPECT_NE(text.find("G33 target 1: nominal (10.000000, 10.000000)"), std::string::npos) << text;
  EXPECT_EQ(text.find("target 2:"), std::string::npos);
  EXPECT_NE(text.find("G33 target 3: nominal (90.000000, 10.000000)"), std::string::npos) << text;
}

}  // namespace
}  // namespace panelcal
