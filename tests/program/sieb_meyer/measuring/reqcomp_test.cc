// SPDX-License-Identifier: Apache-2.0
// SIEB & MEYER manual, 9, G39,REQCOMP: "Get correction value from the camera computer
// (requirement: measurement mode = 3)". What the manual leaves open is assumed with a warning, or
// refused.
#include <cstddef>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::expect_places;
using test::format_5000;
using test::FunctionSource;
using test::Places;
using test::ProgramRun;
using test::run_5000;
using test::run_program;
using test::SubprogramFolder;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kPlaceRounding_mm = 1e-6;

WalkOptions mode_3() {
  WalkOptions options;
  options.sieb_meyer.measurement_mode = 3;
  return options;
}

/// The n-th target is found this far to the right.
FunctionSource shifted_in_turn(std::vector<double> shifts_mm) {
  return FunctionSource([shifts_mm](const MeasurementRequest& request) -> Vector2d {
    return request.nominal.in_mm() +
           Vector2d(shifts_mm.at(static_cast<std::size_t>(request.seq)), 0);
  });
}

Places drilled_at(const ProgramRun& run) {
  Places places;
  for (const test::Hole& hole : run.holes()) places.push_back(hole.corrected_mm());
  return places;
}

std::vector<std::string> assumed_in(const ProgramRun& run) {
  std::vector<std::string> places;
  for (const std::string& text : run.diagnostics) {
    const auto end = text.find(": warning[correction-assumed]");
    if (end != std::string::npos) places.push_back(text.substr(0, end));
  }
  return places;
}

/// `body` is refused by one error of this code in this line, whose text has `words`.
void expect_error(const std::string& body,
                  const std::string& place_and_code,
                  const std::string& words) {
  FunctionSource source = shifted_in_turn({0.1, 0.2, 0.4, 0.8, 1.6});
  const ProgramRun run = run_program(format_5000(body), mode_3(), source);
  EXPECT_THAT(run.texts, Contains(AllOf(HasSubstr(place_and_code), HasSubstr(words)))) << body;
}

/// In force until G30, as behind G39,LOAD. No G31 says so: a warning at the first stroke.
TEST(ManualReqcomp, TurnsOnTheFitOfTheTargetsSoFar) {
  FunctionSource source = shifted_in_turn({0.1, 0.3});
  const ProgramRun run =
      run_5000("X10.Y10.G32\nX10.Y10.G33\nG39,REQCOMP\nX50.Y60.T1\nX60.Y60.\nG30\nX70.Y60.\n",
               mode_3(),
               source);
  expect_places(drilled_at(run), {{50.2, 60}, {60.2, 60}, {70, 60}}, kPlaceRounding_mm);
  EXPECT_THAT(assumed_in(run), ElementsAre("p.exc:5:1"));
  // The cutter goes down where the first stroke is.
  FunctionSource routed = shifted_in_turn({0.1});
  EXPECT_THAT(
      assumed_in(run_5000(
          "X10.Y10.G33\nG39,REQCOMP\nX50.Y60.T0T1\nX70.Y80.G1F1.\nX70.Y80.T0\n", mode_3(), routed)),
      ElementsAre("p.exc:4:1"));
  FunctionSource unused = shifted_in_turn({0.1});
  EXPECT_THAT(assumed_in(run_5000("X10.Y10.G33\nG39,REQCOMP\nG30\nX50.Y60.T1\n", mode_3(), unused)),
              IsEmpty());
}

/// Six targets of two layers, the fourth of which lies where it should not.
FunctionSource board_with_an_outlier(double outlier_mm) {
  return FunctionSource([outlier_mm](const MeasurementRequest& request) -> Vector2d {
    const Vector2d p = request.nominal.in_mm();
    const double layer_mm = request.seq % 2 == 0 ? 0.004 : -0.004;
    const double off_mm = request.seq / 2 == 3 ? outlier_mm : 0;
    return {1.0002 * p.x() - 0.002 * p.y() + 0.3 + off_mm, 0.002 * p.x() + p.y() + layer_mm};
  });
}

/// The value is that of G31, with all that belongs to it: places, sigmas, models, residuals.
TEST(ManualReqcomp, CalculatesWhatG31Calculates) {
  std::string targets;
  for (const char* at : {"X10.Y10.", "X190.Y10.", "X10.Y140.", "X190.Y140.", "X100.Y0", "X0Y75."}) {
    targets += std::string(at) + "G32\n" + at + "G33\n";
  }
  const std::string holes = "X50.Y60.T1\nX120.Y20.\nG30\n";
  WalkOptions dropping = mode_3();
  dropping.base_limits.max_dropped = 1;
  dropping.base_limits.residual = um(50);
  dropping.base_limits.false_alarm = 1e-3;
  WalkOptions choosing = mode_3();
  choosing.chooses_model = true;
  for (const WalkOptions& options : {mode_3(), dropping, choosing}) {
    FunctionSource first = board_with_an_outlier(options.base_limits.max_dropped > 0 ? 0.5 : 0);
    FunctionSource second = first;
    const ProgramRun by_g31 = run_5000(targets + "G31\n" + holes, options, first);
    const ProgramRun requested = run_5000(targets + "G39,REQCOMP\n" + holes, options, second);
    EXPECT_EQ(requested.executed.lines(), by_g31.executed.lines());
    ASSERT_EQ(requested.holes().size(), 2U);
    EXPECT_EQ(requested.holes()[0].drill.cov_mm2, by_g31.holes()[0].drill.cov_mm2);
    EXPECT_GT(requested.holes()[0].drill.cov_mm2.trace(), 0);
    ASSERT_EQ(requested.survey.series.size(), 1U);
    const SeriesResult& fit = requested.survey.series[0];
    const SeriesResult& fit_of_g31 = by_g31.survey.series[0];
    EXPECT_EQ(fit.model, fit_of_g31.model);
    EXPECT_EQ(fit.points, fit_of_g31.points);
    EXPECT_EQ(fit.measurements, fit_of_g31.measurements);
    EXPECT_EQ(fit.dropped, fit_of_g31.dropped);
    EXPECT_EQ(fit.dropped.size(), options.base_limits.max_dropped > 0 ? 1U : 0U);
    EXPECT_NEAR(fit.layer_spread->in_mm(), 0.008, 1e-9);
  }
}

TEST(ManualReqcomp, FailsWithALostTarget) {
  FunctionSource source = shifted_in_turn({0.1, 0.3});
  source.lose(1, MeasurementStatus::NotFound, "dark");
  const ProgramRun run = run_program(
      format_5000("X10.Y10.G33\nX90.Y10.G33\nG39,REQCOMP\nX50.Y60.T1\n"), mode_3(), source);
  EXPECT_TRUE(run.has_errors);
  EXPECT_THAT(run.diagnostics, Contains("p.exc:3:1: error[target-not-found]"));
  EXPECT_THAT(run.holes(), IsEmpty());
}

/// "The measuring process in the measurement modes 2 and 3 must be finished with the G33 command".
TEST(ManualReqcomp, RefusesLayersThatNoG33Finishes) {
  expect_error("X10.Y10.G32\nX10.Y10.G32\nG39,REQCOMP\nX50.Y60.T1\n",
               "p.exc:4:1: error[series-unfinished]",
               "2 layers");
  expect_error("X10.Y10.G33\nX90.Y10.G32\nG39,REQCOMP\nG39,SAVE1\nG39,LOAD1\nX50.Y60.T1\n",
               "p.exc:4:1: error[series-unfinished]",
               "1 layer");
}

/// The targets before it may be used up, as by G31, or count again.
TEST(ManualReqcomp, RefusesTargetsBehindIt) {
  const std::string requested = "X10.Y10.G33\nG39,REQCOMP\n";
  const std::string code = ": error[command-misplaced]";
  expect_error(requested + "X50.Y60.T1\nX90.Y10.G33\nG31\n", "p.exc:5:1" + code, "of line 3");
  expect_error(requested + "X90.Y10.G32\nX90.Y10.G33\nG39,REQCOMP\n", "p.exc:4:1" + code, "G32");
  expect_error(requested + "G30\nX90.Y10.G33\nG31\n", "p.exc:5:1" + code, "of line 3");
  expect_error(
      requested + "G39,SAVE1\nG39,LOAD1\nX90.Y10.G33\nG31\n", "p.exc:6:1" + code, "of line 3");
  // The second copy's target.
  expect_error("M31\nX10.Y10.G33\nG39,REQCOMP\nX50.Y60.T1\nXYM50\nX90.YM50M30\n",
               "p.exc:3:1" + code,
               "of line 4");
  // A hole that is to correct the spindle's offset would be averaged with the board's targets.
  expect_error(requested + "X50.Y60.T1\nG30\nX50.Y60.G33\nG39,SPOP\n", "p.exc:6:1" + code, "G34");
}

TEST(ManualReqcomp, TargetsBehindG31OrG34CountAlone) {
  for (const char* end : {"G31\nG30\n", "G34\n", "G30\nG30\n", "G30\nG31\n"}) {
    FunctionSource source = shifted_in_turn({0.1, 0.5});
    const ProgramRun run = run_5000(
        "X10.Y10.G33\nG39,REQCOMP\n" + std::string(end) + "X90.Y10.G33\nG39,REQCOMP\nX50.Y60.T1\n",
        mode_3(),
        source);
    expect_places(drilled_at(run), {{50.5, 60}}, kPlaceRounding_mm);
    ASSERT_EQ(run.survey.series.size(), 2U);
    EXPECT_EQ(run.survey.series[1].measurements, (std::vector<std::size_t>{1})) << end;
    EXPECT_EQ(assumed_in(run).size(), 1U);
  }
}

/// They are the spindle's then, and no target of the board's.
TEST(ManualReqcomp, GivesItsTargetsToAnOrderForTheOffset) {
  WalkOptions options = mode_3();
  options.moves_offset = true;
  FunctionSource source = shifted_in_turn({0.1, 0.5});
  const ProgramRun run =
      run_5000("X10.Y10.G33\nG39,REQCOMP\nG30\nG39,SPOP\nX90.Y10.G33\nG39,REQCOMP\nX50.Y60.T1\n",
               options,
               source);
  expect_places(drilled_at(run), {{50.5, 60}}, kPlaceRounding_mm);
}

/// G31 calculates the same, or has done so; G39,LOAD turns its set on.
TEST(ManualReqcomp, NeedsNoWarningWhereAllReadingsAgree) {
  for (const char* orders : {"G39,REQCOMP\nG31\n",
                             "G31\nG39,REQCOMP\n",
                             "G39,REQCOMP\nG39,SAVE1\nG39,LOAD1\n",
                             "G39,REQCOMP\nG39,SAVE1\nG34\nG39,LOAD1\n"}) {
    FunctionSource source = shifted_in_turn({0.1, 0.3});
    const ProgramRun run = run_5000(
        "X10.Y10.G32\nX10.Y10.G33\n" + std::string(orders) + "X50.Y60.T1\nG30\n", mode_3(), source);
    expect_places(drilled_at(run), {{50.2, 60}}, kPlaceRounding_mm);
    EXPECT_THAT(assumed_in(run), IsEmpty()) << orders;
    EXPECT_EQ(run.survey.series.size(), 1U) << orders;
  }
}

/// Off again, and on by G39,REQCOMP alone. Targets are fitted once, however often it comes.
TEST(ManualReqcomp, TurnsTheLastValueOnAgain) {
  FunctionSource source = shifted_in_turn({0.1, 0.3});
  const ProgramRun again = run_5000(
      "X10.Y10.G32\nX10.Y10.G33\nG31\nG30\nG39,REQCOMP\nX50.Y60.T1\nG30\n", mode_3(), source);
  expect_places(drilled_at(again), {{50.2, 60}}, kPlaceRounding_mm);
  EXPECT_THAT(assumed_in(again), ElementsAre("p.exc:7:1"));
  EXPECT_EQ(again.survey.series.size(), 1U);

  WalkOptions few = mode_3();
  few.max_operations = 1000;
  const ProgramRun copies = run_program(
      format_5000("X1.Y1.G33\nM31\nG39,REQCOMP\nX1.Y1.M50V2\nX2.Y2.M50W1000000M30\n"), few);
  EXPECT_THAT(copies.texts, Contains(HasSubstr("error[too-many-operations]")));
  EXPECT_EQ(copies.survey.series.size(), 1U);
}

/// The last value of the camera computer is not the one that is loaded, nor the pattern's offset.
TEST(ManualReqcomp, RefusesACorrectionOfOtherTargetsThanTheLast) {
  const std::string two = "X10.Y10.G33\nG31\nG39,SAVE1\nG34\nX90.Y10.G33\nG31\n";
  const std::string code = ": error[command-misplaced]";
  expect_error(two + "G39,LOAD1\nG39,REQCOMP\nX50.Y60.T1\n", "p.exc:9:1" + code, "G39,LOAD");
  expect_error(two + "G39,LOAD1\nG30\nG39,REQCOMP\nX50.Y60.T1\n", "p.exc:10:1" + code, "G39,LOAD");
  expect_error(
      "M49,CAMA\nX10.Y10.G33\nG31\nM31\nX20.Y20.G36\nG39,REQCOMP\nX1.Y1.T1\nXYM50\nX90.YM50M30\n",
      "p.exc:7:1" + code,
      "not of the last targets");
  // G31 would turn on the set that is loaded, or fit the targets again.
  expect_error("X10.Y10.G33\nG31\nG39,SAVE1\nG34\nX90.Y10.G33\nG39,REQCOMP\nG39,LOAD1\nG31\n",
               "p.exc:9:1" + code,
               "of line 7");
  // The set that is loaded is the last value.
  FunctionSource source = shifted_in_turn({0.1, 0.3});
  const ProgramRun run =
      run_5000(two + "G39,SAVE2\nG30\nG39,LOAD2\nG39,REQCOMP\nX50.Y60.T1\n", mode_3(), source);
  expect_places(drilled_at(run), {{50.3, 60}}, kPlaceRounding_mm);
  EXPECT_THAT(assumed_in(run), IsEmpty());
}

/// Under CAMA a pattern's offset is on top of it; the first stroke has the warning.
TEST(ManualReqcomp, IsTheBoardsCorrectionUnderAPatternsOffset) {
  FunctionSource source = shifted_in_turn({0.1, 0.1, 0.3, 0.4});
  const ProgramRun run = run_5000(
      "M49,CAMA\nX10.Y10.G32\nX10.Y10.G33\nG39,REQCOMP\nM31\nX20.Y20.G36\nX50.Y60.T1\nXYM50\n"
      "X90.YM50M30\nG30\n",
      mode_3(),
      source);
  expect_places(drilled_at(run), {{50.3, 60}, {140.4, 60}}, kPlaceRounding_mm);
  EXPECT_THAT(assumed_in(run), ElementsAre("p.exc:8:1"));
}

/// Each copy has the value of its own targets; the warning comes once. As in the manual's example
/// of G39 the values may be saved for another section.
TEST(ManualReqcomp, MayStandInSections) {
  const auto by_copy = [](const MeasurementRequest& request) -> Vector2d {
    return request.nominal.in_mm() + Vector2d(0.1 * (request.path[0] + 1), 0);
  };
  const std::string measured = "M31\nG34\nX10.Y10.G32\nX10.Y10.G33\nG39,REQCOMP\n";
  const std::string copies = "XYM50\nX100.YM50M30\n";
  FunctionSource source(by_copy);
  const ProgramRun run = run_5000(measured + "X20.Y30.T1\n" + copies + "G30\n", mode_3(), source);
  expect_places(drilled_at(run), {{20.1, 30}, {120.2, 30}}, kPlaceRounding_mm);
  EXPECT_THAT(assumed_in(run), ElementsAre("p.exc:7:1"));

  FunctionSource again(by_copy);
  const ProgramRun saved = run_5000(
      measured + "G39,SAVE\nG30\n" + copies + "M31\nG39,LOAD\nX20.Y30.T1\n" + copies + "G30\n",
      mode_3(),
      again);
  expect_places(drilled_at(saved), {{20.1, 30}, {120.2, 30}}, kPlaceRounding_mm);
  EXPECT_THAT(assumed_in(saved), IsEmpty());
}

/// Lines of another file than the message's are named with it.
TEST(ManualReqcomp, NamesTheFileOfItsLine) {
  SubprogramFolder folder;
  folder.with("HOLE.SS5", "@HOLE\nX1.Y1.T1\n").with("SEE.SS5", "@SEE\nX1.Y1.G33\n");
  const ProgramRun run =
      run_5000("X10.Y10.G33\nG39,REQCOMP\nM99,HOLE\n", mode_3(), folder.reading());
  EXPECT_THAT(run.texts,
              Contains(AllOf(HasSubstr("HOLE.SS5:2:1: warning[correction-assumed]"),
                             HasSubstr("of line 3 of p.exc is"))));
  const ProgramRun unused =
      run_program(format_5000("X9.Y9.T1\nM99,SEE\n"), mode_3(), folder.reading());
  EXPECT_THAT(unused.texts,
              Contains(AllOf(HasSubstr("error[series-unfinished]"),
                             HasSubstr("since line 2 of "),
                             HasSubstr("SEE.SS5"))));
}

}  // namespace
}  // namespace panelcal
