// SPDX-License-Identifier: Apache-2.0
// Effect of G34 to G48 on the holes that follow (CNC-7 manual, Vision Assist Commands).
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FunctionSource;
using test::IsNearMatrix;
using test::metric;
using test::ProgramRun;
using test::run_program;

/// Fits of a few hundred millimetres.
constexpr double kRounding_mm = 1e-10;

/// Answers line by line: the target in line n is seen this far from its nominal place.
FunctionSource shifted_by_line(std::map<int, Vector2d> shifts_mm) {
  return FunctionSource([=](const MeasurementRequest& request) -> Vector2d {
    return request.nominal.in_mm() + shifts_mm.at(request.line);
  });
}

ProgramRun run_clean(std::string_view body,
                     FunctionSource& source,
                     const WalkOptions& options = {}) {
  ProgramRun run =
      run_program(metric("G34,1\nT1\n" + std::string(body) + "M30\n"), options, source);
  EXPECT_TRUE(run.diagnostics.empty()) << run.diagnostics.front();
  return run;
}

/// Body lines count from 8.
std::vector<Vector2d> shifts(std::string_view body,
                             std::map<int, Vector2d> target_shifts_mm,
                             const WalkOptions& options = {}) {
  FunctionSource source = shifted_by_line(std::move(target_shifts_mm));
  const ProgramRun run = run_clean(body, source, options);
  std::vector<Vector2d> out;
  for (const test::Hole& hole : run.holes()) {
    out.push_back(hole.actual_mm() - hole.nominal_mm());
  }
  return out;
}

void expect_shifts(const std::vector<Vector2d>& found, const std::vector<Vector2d>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_THAT(found[i], IsNearMatrix(expected[i], kRounding_mm)) << "hole " << i;
  }
}

WalkOptions series_of(int n) {
  WalkOptions options;
  options.series_size = n;
  return options;
}

// --- base corrections ----------------------------------------------------------------------------

TEST(BaseCorrection, HolesBeforeATargetStayWhereTheyAre) {
  expect_shifts(shifts("X1.Y1.\nG35X2.Y2.\nX3.Y3.\n", {{9, {.1, .2}}}), {{0, 0}, {.1, .2}});
}

TEST(BaseCorrection, G35ShiftsAllThatFollows) {
  expect_shifts(shifts("G35X2.Y2.\nX1.Y1.\nX100.Y50.\n", {{8, {.1, -.2}}}), {{.1, -.2}, {.1, -.2}});
}

TEST(BaseCorrection, TwoG36GiveOffsetAndRotation) {
  // The second target lies 1 in 100 to the left of where it should be.
  const double angle_rad = std::asin(0.01);
  FunctionSource source([&](const MeasurementRequest& request) -> Vector2d {
    const Vector2d& p = request.nominal.in_mm();
    return {std::cos(angle_rad) * p.x() - std::sin(angle_rad) * p.y() + 1,
            std::sin(angle_rad) * p.x() + std::cos(angle_rad) * p.y()};
  });
  const ProgramRun run =
      run_clean("G36X0.Y0.\nG36X100.Y0.\nX0.Y0.\nX0.Y200.\n", source, series_of(2));
  EXPECT_EQ(run.survey.series.at(0).model, PanelModel::Rigid);
  EXPECT_THAT(run.holes()[0].actual_mm(), IsNearMatrix(Vector2d(1, 0), kRounding_mm));
  EXPECT_THAT(run.holes()[1].actual_mm(),
              IsNearMatrix(Vector2d(-1, 200 * std::cos(angle_rad)), kRounding_mm));
}

TEST(BaseCorrection, ThreeG36GiveOffsetRotationAndStretch) {
  FunctionSource source([](const MeasurementRequest& request) -> Vector2d {
    const Vector2d& p = request.nominal.in_mm();
    return {1.001 * p.x() + 0.5, 0.998 * p.y()};
  });
  const ProgramRun run =
      run_clean("G36X0.Y0.\nG36X100.Y0.\nG36X0.Y100.\nX50.Y50.\n", source, series_of(3));
  EXPECT_EQ(run.survey.series.at(0).model, PanelModel::Stretch);
  EXPECT_THAT(run.holes()[0].actual_mm(), IsNearMatrix(Vector2d(50.55, 49.9), kRounding_mm));
}

TEST(BaseCorrection, TheConfiguredModelRulesForSeries) {
  WalkOptions options = series_of(2);
  options.model = PanelModel::Similarity;
  FunctionSource source(
      [](const MeasurementRequest& request) -> Vector2d { return 1.01 * request.nominal.in_mm(); });
  const ProgramRun run =
      run_clean("G36X0.Y0.\nG36X100.Y0.\nX0.Y200.\nG35X0.Y0.\n", source, options);
  EXPECT_THAT(run.holes()[0].actual_mm(), IsNearMatrix(Vector2d(0, 202), kRounding_mm));
  EXPECT_EQ(run.survey.series.at(1).model, PanelModel::Offset);  // a single point has no other
}

TEST(BaseCorrection, TheNextG36AfterACompleteSeriesBeginsANewOne) {
  expect_shifts(shifts("G36X0.Y0.\nG36X9.Y0.\nX1.Y1.\nG36X0.Y0.\nG36X9.Y0.\nX1.Y1.\n",
                       {{8, {1, 0}}, {9, {1, 0}}, {11, {0, 1}}, {12, {0, 1}}},
                       series_of(2)),
                {{1, 0}, {0, 1}});
}

TEST(BaseCorrection, G35ReplacesG36AndTheOtherWayRound) {
  expect_shifts(shifts("G36X0.Y0.\nG36X9.Y0.\nG35X0.Y0.\nX1.Y1.\nG36X0.Y0.\nG36X9.Y0.\nX1.Y1.\n",
                       {{8, {1, 0}}, {9, {1, 0}}, {10, {0, 2}}, {12, {3, 0}}, {13, {3, 0}}},
                       series_of(2)),
                {{0, 2}, {3, 0}});
}

TEST(BaseCorrection, TargetsOfANewOneAreLookedForAtTheirNominalPlaces) {
  FunctionSource source = test::shifted_by(1, 1);
  run_clean("G35X0.Y0.\nG35X5.Y6.\n", source);
  EXPECT_EQ(source.requests().at(1).expected.in_mm(), Vector2d(5, 6));
}

TEST(BaseCorrection, G37DropsBaseAndNested) {
  expect_shifts(shifts("G35X0.Y0.\nG45X0.Y0.\nX1.Y1.\nG37\nX1.Y1.\n", {{8, {1, 0}}, {9, {1, 2}}}),
                {{1, 2}, {0, 0}});
}

TEST(BaseCorrection, ANewOneDropsTheNestedOne) {
  expect_shifts(
      shifts("G35X0.Y0.\nG45X0.Y0.\nG35X0.Y0.\nX1.Y1.\n", {{8, {1, 0}}, {9, {1, 2}}, {10, {3, 0}}}),
      {{3, 0}});
}

// --- nested corrections --------------------------------------------------------------------------

TEST(NestedCorrection, TargetsAreLookedForWhereTheBasePutsThem) {
  FunctionSource source = test::shifted_by(1, 2);
  const ProgramRun run = run_clean("G35X0.Y0.\nG45X5.Y6.\nX0.Y0.\n", source);
  EXPECT_EQ(source.requests().at(1).nominal.in_mm(), Vector2d(5, 6));
  EXPECT_EQ(source.requests().at(1).expected.in_mm(), Vector2d(6, 8));
  EXPECT_EQ(run.survey.series.at(1).base_series, 0U);
}

TEST(NestedCorrection, WorksOnTopOfTheBase) {
  expect_shifts(shifts("G35X0.Y0.\nX1.Y1.\nG45X0.Y0.\nX1.Y1.\n", {{8, {1, 0}}, {10, {1.5, .25}}}),
                {{1, 0}, {1.5, .25}});
}

TEST(NestedCorrection, WorksWithoutABaseToo) {
  expect_shifts(shifts("G45X0.Y0.\nX1.Y1.\n", {{8, {1, 2}}}), {{1, 2}});
}

TEST(NestedCorrection, G45ReplacesG46AndTheOtherWayRound) {
  expect_shifts(shifts("G46X0.Y0.\nG46X9.Y0.\nG45X0.Y0.\nX1.Y1.\nG46X0.Y0.\nG46X9.Y0.\nX1.Y1.\n",
                       {{8, {1, 0}}, {9, {1, 0}}, {10, {0, 2}}, {12, {3, 0}}, {13, {3, 0}}},
                       series_of(2)),
                {{0, 2}, {3, 0}});
}

TEST(NestedCorrection, G47DropsItAndLeavesTheBase) {
  expect_shifts(shifts("G35X0.Y0.\nG45X0.Y0.\nG47\nX1.Y1.\n", {{8, {1, 0}}, {9, {5, 5}}}),
                {{1, 0}});
}

TEST(NestedCorrection, HolesCarryTheUncertaintyOfBothFits) {
  FunctionSource source = test::shifted_by(0, 0);
  const ProgramRun run = run_clean("X0.Y0.\nG35X0.Y0.\nX0.Y0.\n", source);
  EXPECT_EQ(run.holes()[0].drill.cov_mm2, Eigen::Matrix2d::Zero());
  EXPECT_THAT(run.holes()[1].drill.cov_mm2,
              IsNearMatrix(Eigen::Matrix2d(1e-6 * Eigen::Matrix2d::Identity()), 1e-15));
}

// --- holes at targets ----------------------------------------------------------------------------

TEST(HoleAtTarget, G38DrillsWhereTheTargetIs) {
  FunctionSource source = test::shifted_by(.25, .5);
  const ProgramRun run = run_clean("G38X5.Y6.\n", source);
  EXPECT_EQ(run.holes().at(0).nominal_mm(), Vector2d(5, 6));
  EXPECT_EQ(run.holes().at(0).actual_mm(), Vector2d(5.25, 6.5));
  EXPECT_EQ(run.holes().at(0).drill.cov_mm2, 1e-6 * Eigen::Matrix2d::Identity());
}

TEST(HoleAtTarget, G38LooksRelativeToWorkZeroAndG48RelativeToTheBase) {
  FunctionSource source = test::shifted_by(1, 2);
  run_clean("G35X0.Y0.\nG45X0.Y0.\nG38X5.Y6.\nG48X5.Y6.\n", source);
  EXPECT_EQ(source.requests().at(2).expected.in_mm(), Vector2d(5, 6));
  EXPECT_EQ(source.requests().at(3).expected.in_mm(), Vector2d(6, 8));
}

TEST(HoleAtTarget, ChangesNoCorrection) {
  const std::map<int, Vector2d> seen = {{8, {1, 0}}, {9, {1, 2}}, {10, {7, 7}}, {11, {8, 8}}};
  expect_shifts(shifts("G35X0.Y0.\nG45X0.Y0.\nG38X5.Y6.\nG48X5.Y6.\nX1.Y1.\n", seen),
                {{7, 7}, {8, 8}, {1, 2}});
}

/// "G38 is not affected by, nor does it affect the current G35 or G36": an open series goes on.
TEST(HoleAtTarget, MayStandInsideOfASeries) {
  const std::map<int, Vector2d> seen = {{8, {1, 2}}, {9, {7, 7}}, {10, {1, 2}}, {11, {1, 2}}};
  expect_shifts(shifts("G36X0.Y0.\nG38X5.Y6.\nG36X90.Y0.\nG36X0.Y90.\nX1.Y1.\n", seen),
                {{7, 7}, {1, 2}});
  expect_shifts(shifts("G46X0.Y0.\nG48X5.Y6.\nG46X90.Y0.\nG46X0.Y90.\nX1.Y1.\n", seen),
                {{7, 7}, {1, 2}});
}

TEST(HoleAtTarget, IsPlacedByStepAndRepeat) {
  FunctionSource source = test::shifted_by(.5, 0);
  const ProgramRun run = run_clean("M25\nG38X1.Y1.\nM01\nM02X10.M80\nM08\n", source);
  EXPECT_EQ(run.holes().at(1).nominal_mm(), Vector2d(9, 1));
  EXPECT_EQ(run.holes().at(1).actual_mm(), Vector2d(9.5, 1));
  EXPECT_EQ(run.holes().at(1).path, InstancePath{1});
}

// --- G34, work zero ------------------------------------------------------------------------------

TEST(VisionTool, ManualFormsOfG34) {
  FunctionSource source = test::shifted_by(0, 0);
  run_clean("G35X0.Y0.\nG34,2,.5\nG35X0.Y0.\nG34,1,2,3,4,1.5\nG35X0.Y0.\nG34,3\nG35X0.Y0.\n",
            source);
  const auto& requests = source.requests();
  EXPECT_EQ(requests.at(0).settings.tools, std::vector<int>{1});
  EXPECT_EQ(requests.at(1).settings.tools, std::vector<int>{2});
  EXPECT_EQ(requests.at(1).settings.delta, mm(.5));
  EXPECT_EQ(requests.at(2).settings.tools, (std::vector<int>{1, 2, 3, 4}));
  EXPECT_EQ(requests.at(2).settings.delta, mm(1.5));
  EXPECT_EQ(requests.at(3).settings.tools, std::vector<int>{3});
  EXPECT_EQ(requests.at(3).settings.delta, std::nullopt);
}

TEST(WorkZero, IsAddedToMeasurementsAndHolesAlike) {
  FunctionSource source = test::shifted_by(.5, 0);
  const ProgramRun run = run_clean("G93X100.Y200.\nG35X1.Y1.\nX2.Y2.\n", source);
  EXPECT_EQ(source.requests().at(0).expected.in_mm(), Vector2d(1, 1));
  EXPECT_EQ(source.requests().at(0).expected_in_machine(), position_mm<frame::Machine>(101, 201));
  EXPECT_EQ(run.holes().at(0).corrected_mm(), Vector2d(2.5, 2));
  EXPECT_EQ(run.holes().at(0).actual_mm(), Vector2d(102.5, 202));
}

TEST(WorkZero, MayBeSetAgainOnceTheCorrectionIsCancelled) {
  expect_shifts(shifts("G35X1.Y1.\nG37\nG93X0.Y0.\nX2.Y2.\n", {{8, {1, 0}}}), {{0, 0}});
}

// --- orders to the camera ------------------------------------------------------------------------

/// Focuses on anything.
class FocusingSource final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    return NominalSource().measure(request);
  }
  Expected<std::optional<FocusResult>> focus(const MeasurementRequest& request) override {
    FocusResult result;
    result.request = request;
    result.is_found = request.expected.in_mm().x() < 100;
    result.z = mm(0.25);
    result.reason = "too far away";
    return std::optional(result);
  }
};

TEST(AutoFocus, IsAskedForAtItsPlaceWithTheSettingsInForce) {
  FocusingSource source;
  WalkOptions options;
  options.has_focus = true;
  const ProgramRun run = run_program(metric("$uvis,lamp,30\n$uvis,focus,x20.0y15.0\n$uvis,lamp,5\n$"
                                            "uvis,focus,xy\nT1\nX1.0Y1.0\nM30\n"),
                                     options,
                                     source);
  EXPECT_TRUE(run.diagnostics.empty()) << run.diagnostics.front();
  ASSERT_EQ(run.survey.focus.size(), 2u);
  const MeasurementRequest& request = run.survey.focus[0].request;
  EXPECT_EQ(request.line, 7);
  EXPECT_EQ(request.seq, -1);
  EXPECT_EQ(request.settings.lamp, 30);
  EXPECT_EQ(request.expected, position_mm<frame::Actual>(20, 15));
  EXPECT_EQ(run.survey.focus[1].request.expected, position_mm<frame::Actual>(0, 0));
  // The order is passed on all the same.
  EXPECT_EQ(run.executed.lines()[2], "7 setting $uvis,focus,x20.0y15.0");
}

TEST(AutoFocus, FailureIsAnError) {
  FocusingSource source;
  WalkOptions options;
  options.has_focus = true;
  const ProgramRun run =
      run_program(metric("$uvis,focus,x200.0y15.0\nT1\nX1.0Y1.0\nM30\n"), options, source);
  ASSERT_EQ(run.diagnostics.size(), 1u);
  EXPECT_EQ(run.diagnostics[0], "p.exc:6:1: error[focus-not-found]");
}

TEST(SearchArea, IsAPlainNumberInTheProgramsUnit) {
  FunctionSource source = test::shifted_by(0, 0);
  run_program(
      metric("G34,1\n$uvis,searcharea,2.5\nG38X1.0Y1.0\n$uvis,searcharea,3\nG38X2.0Y1.0\nM30\n"),
      {},
      source);
  ASSERT_EQ(source.requests().size(), 2u);
  EXPECT_EQ(source.requests()[0].settings.search_area, mm(2.5));
  EXPECT_EQ(source.requests()[1].settings.search_area, mm(3));
  FunctionSource inches = test::shifted_by(0, 0);
  run_program(test::inch_leading_zeros("G34,1\n$uvis,searcharea,.1\nG38X01Y01\nM30\n"), {}, inches);
  ASSERT_EQ(inches.requests().size(), 1u);
  EXPECT_EQ(inches.requests()[0].settings.search_area, inch(0.1));
}

}  // namespace
}  // namespace panelcal
