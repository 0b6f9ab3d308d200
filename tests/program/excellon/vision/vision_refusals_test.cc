// SPDX-License-Identifier: Apache-2.0
// Refusals of a survey: unfinished and degenerate series, lost targets, gates, mixed passes.
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FunctionSource;
using test::metric;
using test::ProgramRun;
using test::Reports;
using test::run_program;
using testing::ElementsAre;

using Texts = std::vector<std::string>;

/// Body lines count from 8; a series has three targets.
std::string program(std::string_view body) {
  return metric("G34,1\nT1\n" + std::string(body) + "M30\n");
}

Texts diagnostics_of(std::string_view body) {
  return run_program(program(body)).diagnostics;
}

// --- unfinished series ---------------------------------------------------------------------------

std::string unfinished(int line) {
  return "p.exc:" + std::to_string(line) + ":1: error[series-unfinished]";
}

TEST(SeriesUnfinished, ByACoordinate) {
  EXPECT_EQ(diagnostics_of("G36X0.Y0.\nG36X9.Y0.\nX1.Y1.\n"), Texts{unfinished(10)});
}

TEST(SeriesUnfinished, ByAnotherCommand) {
  const std::string begun = "G36X0.Y0.\nG36X9.Y0.\n";
  EXPECT_EQ(diagnostics_of(begun + "G35X1.Y1.\n"), Texts{unfinished(10)});
  EXPECT_EQ(diagnostics_of(begun + "G45X1.Y1.\n"), Texts{unfinished(10)});
  EXPECT_EQ(diagnostics_of(begun + "G48X1.Y1.\n"), Texts{unfinished(10)});
  EXPECT_EQ(diagnostics_of(begun + "G37\n"), Texts{unfinished(10)});
  EXPECT_EQ(diagnostics_of(begun + "G47\n"), Texts{unfinished(10)});
  EXPECT_EQ(diagnostics_of(begun + "M51,1\n").at(0), unfinished(10));
}

TEST(SeriesUnfinished, ByTheEndOfThePattern) {
  EXPECT_EQ(diagnostics_of("G36X0.Y0.\nM25\nG36X9.Y0.\nM01\nM08\n"), Texts{unfinished(11)});
}

TEST(SeriesUnfinished, ByTheEnd) {
  EXPECT_EQ(diagnostics_of("G36X0.Y0.\nG36X9.Y0.\n"), Texts{unfinished(10)});
  const std::string cut = metric("G34,1\nT1\nG36X0.Y0.\nG36X9.Y0.\n");
  EXPECT_EQ(run_program(cut).diagnostics.at(0), unfinished(10));
}

TEST(SeriesUnfinished, ToolsAndVisionSettingsMayComeBetween) {
  EXPECT_EQ(diagnostics_of("G36X0.Y0.\nT2\nG34,2\n$uvis,lamp,5\nG36X9.Y0.\nG36X0.Y9.\n"), Texts{});
}

// --- fits that fail ------------------------------------------------------------------------------

TEST(SeriesDegenerate, CollinearTargetsDoNotDetermineAStretch) {
  EXPECT_EQ(diagnostics_of("G36X0.Y0.\nG36X9.Y9.\nG36X18.Y18.\n"),
            Texts{"p.exc:8:1: error[series-degenerate]"});
}

TEST(SeriesDegenerate, TooFewTargetsForTheConfiguredModel) {
  WalkOptions options;
  options.series_size = 2;
  options.model = PanelModel::Affine;
  EXPECT_EQ(run_program(program("G36X0.Y0.\nG36X9.Y9.\n"), options).diagnostics,
            Texts{"p.exc:8:1: error[targets-too-few]"});
}

TEST(SeriesDegenerate, AMeasurementWithoutAUsableCovarianceIsNamed) {
  class ExactSource final : public MeasurementSource {
    Expected<Measurement> measure(const MeasurementRequest& request) override {
      Measurement measurement{.request = request, .status = MeasurementStatus::Found};
      measurement.measured.position = request.expected;
      return measurement;
    }
  };
  ExactSource source;
  EXPECT_EQ(run_program(program("G35X0.Y0.\n"), {}, source).diagnostics,
            Texts{"p.exc:8:1: error[measurement-invalid]"});
}

TEST(PanelMirrored, ASeriesSeenAsInAMirrorIsRefusedWithoutAnyLimit) {
  for (const char* code : {"G36", "G46"}) {
    FunctionSource source([](const MeasurementRequest& request) -> Vector2d {
      return {-request.nominal.in_mm().x(), request.nominal.in_mm().y()};
    });
    const std::string g = code;
    EXPECT_EQ(run_program(program(g + "X0.Y0.\n" + g + "X9.Y0.\n" + g + "X0.Y9.\n"), {}, source)
                  .diagnostics,
              Texts{"p.exc:8:1: error[panel-mirrored]"});
  }
}

// --- lost targets --------------------------------------------------------------------------------

TEST(LostTarget, InABaseSeriesStopsTheSurvey) {
  FunctionSource source = test::shifted_by(0, 0);
  source.lose(1, MeasurementStatus::NotFound, "too dark");
  const ProgramRun run =
      run_program(program("G36X0.Y0.\nG36X9.Y0.\nG36X0.Y9.\nX1.Y1.\nG46X0.Y0.\n"), {}, source);
  EXPECT_THAT(run.texts,
              ElementsAre(Reports(
                  "p.exc:9:1: error[target-not-found]", "(9.0000, 0.0000) mm", "too dark")));
  EXPECT_EQ(source.requests().size(), 3U);
  EXPECT_FALSE(run.survey.is_complete());
  EXPECT_FALSE(run.survey.is_accepted());
}

TEST(LostTarget, InANestedSeriesLetsTheSurveyGoOn) {
  FunctionSource source = test::shifted_by(0, 0);
  source.lose(0, MeasurementStatus::Ambiguous, "");
  const ProgramRun run =
      run_program(program("M25\nG45X1.Y2.\nX1.Y1.\nM01\nM02X10.\nM08\n"), {}, source);
  EXPECT_EQ(run.diagnostics, Texts{"p.exc:9:1: error[target-ambiguous]"});
  EXPECT_EQ(source.requests().size(), 2U);
  EXPECT_FALSE(run.survey.series.at(0).is_fitted());
  EXPECT_TRUE(run.survey.series.at(1).is_accepted());
  EXPECT_FALSE(run.survey.is_complete());
}

TEST(LostTarget, UnderAHoleFailsTheSurveyToo) {
  FunctionSource source = test::shifted_by(0, 0);
  source.lose(0, MeasurementStatus::Rejected, "a cross, not a disc");
  const ProgramRun run = run_program(program("G38X1.Y2.\n"), {}, source);
  EXPECT_THAT(
      run.texts,
      ElementsAre(Reports(
          "p.exc:8:1: error[target-rejected]", "(1.0000, 2.0000) mm", "a cross, not a disc")));
  EXPECT_FALSE(run.survey.is_complete());
}

TEST(LostTarget, AFailingSourceStopsTheSurveyWithItsOwnWords) {
  class BrokenSource final : public MeasurementSource {
    Expected<Measurement> measure(const MeasurementRequest&) override {
      return failure({Code::FileUnreadable, {"a.png", 0, 0}, "no such file", ""});
    }
  };
  BrokenSource source;
  EXPECT_THAT(run_program(program("G35X0.Y0.\nG35X1.Y1.\n"), {}, source).texts,
              ElementsAre(Reports("a.png: error[file-unreadable]", "no such file")));
}

// --- gates ---------------------------------------------------------------------------------------

TEST(VisionGates, AResidualNamesThePad) {
  // Three targets leave one equation over for the stretch model; 4 leave three.
  WalkOptions options;
  options.series_size = 4;
  options.base_limits.residual = um(20);
  FunctionSource source([](const MeasurementRequest& request) -> Vector2d {
    const double slip_mm = request.line == 10 ? 0.2 : 0;
    return request.nominal.in_mm() + Vector2d(slip_mm, 0);
  });
  const ProgramRun run =
      run_program(program("G36X0.Y0.\nG36X100.Y0.\nG36X100.Y100.\nG36X0.Y100.\n"), options, source);
  EXPECT_THAT(run.texts,
              ElementsAre(Reports(
                  "p.exc:10:1: error[gate-failed]", "3", "G36", "(100.0000, 100.0000) mm")));
  EXPECT_TRUE(run.survey.is_complete());
  EXPECT_FALSE(run.survey.is_accepted());
  EXPECT_TRUE(run.holes().empty());
}

TEST(VisionGates, BaseAndNestedHaveLimitsOfTheirOwn) {
  WalkOptions options;
  options.nested_limits.offset = mm(0.5);
  FunctionSource far = test::shifted_by(1, 0);
  EXPECT_EQ(run_program(program("G35X0.Y0.\n"), options, far).diagnostics, Texts{});
  FunctionSource nested = test::shifted_by(1, 0);
  EXPECT_THAT(run_program(program("G45X0.Y0.\n"), options, nested).texts,
              ElementsAre(Reports("p.exc:8:1: error[gate-failed]", "1.000 mm", "0.500 mm", "G45")));
}

// --- what the two passes would see differently ---------------------------------------------------

TEST(AxisAmbiguous, AHoleTakesNoAxisFromATarget) {
  EXPECT_EQ(diagnostics_of("G35X1.Y1.\nX2.\n"), Texts{"p.exc:9:1: error[axis-ambiguous]"});
}

TEST(AxisAmbiguous, ATargetTakesNoAxisFromAHole) {
  EXPECT_EQ(diagnostics_of("X1.Y1.\nG35Y2.\n"), Texts{"p.exc:9:1: error[axis-ambiguous]"});
}

TEST(AxisAmbiguous, AnIncrementalHoleDoesNotGoOnFromATarget) {
  EXPECT_EQ(diagnostics_of("G35X1.Y1.\nG91\nX2.Y2.\n"), Texts{"p.exc:10:1: error[axis-ambiguous]"});
}

TEST(AxisAmbiguous, AnOmittedAxisAfterM08IsNotGuessed) {
  EXPECT_EQ(diagnostics_of("M25\nX1.Y1.\nM01\nM08\nX2.\n"),
            Texts{"p.exc:12:1: error[axis-ambiguous]"});
}

/// The manual says neither that a pattern's first line goes on from before it nor that a copy goes
/// on from the end of the one before. G91 does: it "clears" at M08 alone.
TEST(AxisAmbiguous, APatternTakesNoAxisFromBeforeIt) {
  const Texts refused{"p.exc:10:1: error[axis-ambiguous]"};
  const std::string end = "M01\nM02X10.Y0.\nM02\nM08\n";
  EXPECT_EQ(diagnostics_of("X1.Y2.\nM25\nX3.\nX5.Y5.\n" + end), refused);
  EXPECT_EQ(diagnostics_of("X1.Y2.\nM25\nY3.\n" + end), refused);
  EXPECT_EQ(diagnostics_of("M25\nX3.\nX4.Y4.\n" + end), Texts{"p.exc:9:1: error[axis-ambiguous]"});
  EXPECT_EQ(diagnostics_of("M25\nX3.Y3.\nX4.\nY5.\n" + end), Texts{});
  EXPECT_EQ(diagnostics_of("X1.Y2.\nG91\nM25\nX3.\n" + end), Texts{});
}

/// Places of stops count from absolute zero, those of holes from work zero.
TEST(AxisAmbiguous, AHoleTakesNoAxisFromBeforeAStopWithAPlace) {
  for (const std::string stop : {"M06X5.Y5.\n", "M09X5.Y5.\n"}) {
    const Texts refused{"p.exc:10:1: error[axis-ambiguous]"};
    EXPECT_EQ(diagnostics_of("X1.Y1.\n" + stop + "X2.\n"), refused) << stop;
    EXPECT_EQ(diagnostics_of("X1.Y1.\n" + stop + "X2.Y3.\nX4.\n"), Texts{}) << stop;
  }
  EXPECT_EQ(diagnostics_of("X1.Y1.\nM09\nX2.\n"), Texts{});
}

/// Behind M08 each of these blocks would have said where the axes are, had it been right.
TEST(AxisAmbiguous, LinesBehindARefusedOneAreNotBlamedForIt) {
  const std::string section = "M25\nX1.Y1.\nM01\nM08\n";
  const auto refused_for = [](const std::string& code) { return Texts{"p.exc:12:" + code}; };
  EXPECT_EQ(diagnostics_of(section + "X7.QY8.\nX5.\nY6.\n"),
            refused_for("4: error[block-not-alone]"));
  EXPECT_EQ(diagnostics_of(section + "X7.Y999999999\nX5.\nY6.\n"),
            refused_for("5: error[number-too-long]"));
  EXPECT_EQ(diagnostics_of(section + "G91Q\nX5.\nY6.\n"), refused_for("4: error[block-not-alone]"));
  EXPECT_EQ(diagnostics_of(section + "X7.\nY8.\nX5.\n"), refused_for("1: error[axis-ambiguous]"));
  // What clears the axes again is a cause of its own, also behind errors inside of a section.
  const std::string again = "M25\nX3.QY3.\nX4.\nM01\nM08\nX5.\n";
  EXPECT_EQ(diagnostics_of(section + again),
            (Texts{"p.exc:13:4: error[block-not-alone]", "p.exc:17:1: error[axis-ambiguous]"}));
}

TEST(AxisAmbiguous, TargetsMayTakeAnAxisFromTargets) {
  FunctionSource source = test::shifted_by(0, 0);
  const ProgramRun run = run_program(program("G36X1.Y1.\nG36X9.\nG36Y9.\nX0.Y0.\n"), {}, source);
  EXPECT_EQ(run.diagnostics, Texts{});
  EXPECT_EQ(source.requests().at(2).nominal.in_mm(), Vector2d(9, 9));
}

TEST(AxisAmbiguous, ARepeatDoesNotGoOnFromATarget) {
  const std::string expected = "error[repeat-without-hole]";
  EXPECT_EQ(diagnostics_of("X0.Y0.\nG35X1.Y1.\nR2X1.\n"), Texts{"p.exc:10:1: " + expected});
  EXPECT_EQ(diagnostics_of("X0.Y0.\nG38X1.Y1.\nR2X1.\n"), Texts{"p.exc:10:1: " + expected});
}

// --- G93 -----------------------------------------------------------------------------------------

TEST(ZeroSet, IsRefusedUnderACorrection) {
  const std::string expected = "error[zero-set-under-correction]";
  EXPECT_EQ(diagnostics_of("G35X0.Y0.\nG93X1.Y1.\n"), Texts{"p.exc:9:1: " + expected});
  EXPECT_EQ(diagnostics_of("G36X0.Y0.\nG93X1.Y1.\n").at(0), "p.exc:9:1: " + expected);
  EXPECT_EQ(diagnostics_of("M50,1\nM25\nG35X0.Y0.\nM01\nM08\nG37\nG93X1.Y1.\n"),
            Texts{"p.exc:14:1: " + expected});
}

TEST(ZeroSet, IsRefusedInAPattern) {
  EXPECT_EQ(diagnostics_of("M25\nG93X1.Y1.\nM01\nM08\n"),
            Texts{"p.exc:9:1: error[command-misplaced]"});
}

}  // namespace
}  // namespace panelcal
