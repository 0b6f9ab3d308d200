// SPDX-License-Identifier: Apache-2.0
// Orders to calibrate between measurements: who is asked for what, and what later holes make of it.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "program/judge/explain.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::IsNearMatrix;
using test::metric;
using test::ProgramRun;
using test::run_program;
using test::says;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr double kRounding_mm2 = 1e-14;
constexpr double kUm2 = 1e-6;

Eigen::Matrix2d um2(double variance) {
  return variance * kUm2 * Eigen::Matrix2d::Identity();
}

/// Sees every target 10 um right of its expected place, with 4 um^2, and calibrates to 25 um^2.
class CalibratingSource final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    Measurement m{.request = request, .status = MeasurementStatus::Found};
    m.measured = {request.expected + displacement_mm<frame::Actual>(0.01, 0), um2(4)};
    return m;
  }
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override {
    orders.push_back(order);
    if (fails) return failure({Code::DeviceStage, {"stage", 0, 0}, "the drill is broken", ""});
    CalibrationAnswer answer;
    answer.offset = SpindleCameraOffset{displacement_mm<frame::Machine>(45, -3),
                                        25e-6 * Eigen::Matrix2d::Identity()};
    answer.text = "found";
    return answer;
  }

  std::vector<CalibrationOrder> orders;
  bool fails = false;
};

/// The offset of the machine's file is worth 100 um^2, and its drift 36.
WalkOptions with_coupon() {
  WalkOptions options;
  options.has_coupon = true;
  options.work_zero = position_mm<frame::Machine>(100, 200);
  options.uncertainty.spindle_camera_mm2 = um2(100);
  options.uncertainty.drift_mm2 = um2(36);
  return options;
}

/// CNC-7 manual, Vision System Autocalibration: "The coordinate provided with the G39 is the
/// location of the first calibration hole [...] relative to the current work zero".
TEST(ManualG39, SaysWhereTheFirstHoleIsDrilled) {
  CalibratingSource source;
  const ProgramRun run = run_program(metric("T1\nG39X1.Y2.\nX5.Y5.\nM30\n"), with_coupon(), source);
  EXPECT_THAT(run.diagnostics, IsEmpty());
  ASSERT_EQ(source.orders.size(), 1U);
  const CalibrationOrder& order = source.orders[0];
  EXPECT_EQ(order.command, "G39");
  EXPECT_EQ(order.line, 7);
  EXPECT_EQ(order.number, 0);
  EXPECT_EQ(order.first_hole, position_mm<frame::Machine>(101, 202));
  EXPECT_FALSE(order.correction);
  // The order is the machine's as well.
  EXPECT_THAT(run.executed.lines(), Contains("7 autocalibration (101, 202)"));
}

TEST(ManualG39, IsNotAffectedByATranslationAndDoesNotAffectIt) {
  CalibratingSource source;
  const ProgramRun run = run_program(
      metric("G34,1\nG35X1.Y1.\nT1\nX5.Y5.\nG39X1.Y2.\nX5.Y5.\nM30\n"), with_coupon(), source);
  ASSERT_EQ(source.orders.size(), 1U);
  EXPECT_EQ(source.orders[0].first_hole, position_mm<frame::Machine>(101, 202));
  ASSERT_EQ(run.holes().size(), 2U);
  EXPECT_EQ(run.holes()[0].drill.actual, run.holes()[1].drill.actual);
  // A fit measured before stays as uncertain as it was: 4 + 100 + 36.
  for (const test::Hole& hole : run.holes()) {
    EXPECT_THAT(hole.drill.cov_mm2, IsNearMatrix(um2(140), kRounding_mm2));
  }
}

/// "G39(X#Y#)": the parentheses say that the coordinate may be left out.
TEST(ManualG39, WithoutACoordinateTheCouponSaysWhere) {
  CalibratingSource source;
  const ProgramRun run = run_program(metric("T1\nG39\nX5.Y5.\nM30\n"), with_coupon(), source);
  EXPECT_THAT(run.diagnostics, IsEmpty());
  ASSERT_EQ(source.orders.size(), 1U);
  EXPECT_FALSE(source.orders[0].first_hole);
  EXPECT_THAT(run.executed.lines(), Contains("7 setting G39"));
}

/// CNC-7 manual, Part Program Vision Commands Examples: a calibration at each zoom, with the light
/// that is on.
TEST(ManualUvisCalib, IsDoneWithTheZoomAndTheLampInForce) {
  CalibratingSource source;
  const ProgramRun run =
      run_program(metric("$uvis,zoom,7\n$uvis,lamp,30\n$uvis,zoom,3\n$uvis,calib\n"
                         "$uvis,lamp,25\nT1\nG34,2\n$uvis,zoom,7\n$uvis,calib\n"
                         "$uvis,lamp,55\nX1.Y1.\nM30\n"),
                  with_coupon(),
                  source);
  EXPECT_THAT(run.diagnostics, IsEmpty());
  ASSERT_EQ(source.orders.size(), 2U);
  EXPECT_EQ(source.orders[0].command, "$uvis,calib");
  EXPECT_EQ(source.orders[0].line, 9);
  EXPECT_EQ(source.orders[0].zoom, 3);
  EXPECT_EQ(source.orders[0].lamp, 30);
  EXPECT_FALSE(source.orders[0].first_hole);
  EXPECT_EQ(source.orders[1].number, 1);
  EXPECT_EQ(source.orders[1].zoom, 7);
  EXPECT_EQ(source.orders[1].lamp, 25);
  EXPECT_THAT(run.executed.lines(), Contains("9 setting $uvis,calib"));
}

TEST(CalibrationOrders, ArePassedOnWithAWarningWhereNobodyCan) {
  for (const bool has_coupon : {false, true}) {
    test::FunctionSource source = test::shifted_by(0, 0);  // which calibrates nothing
    WalkOptions options;
    options.has_coupon = has_coupon;
    const ProgramRun run =
        run_program(metric("$uvis,calib\nT1\nG39X1.Y2.\nX5.Y5.\nM30\n"), options, source);
    EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
    EXPECT_THAT(run.diagnostics,
                ElementsAre("p.exc:6:1: warning[calibration-not-performed]",
                            "p.exc:8:1: warning[calibration-not-performed]"));
    EXPECT_THAT(run.survey.calibrations, IsEmpty());
    EXPECT_THAT(run.executed.lines(), Contains("6 setting $uvis,calib, not performed"));
  }
}

TEST(CalibrationOrders, WithoutACouponACoordinateIsNeeded) {
  const ProgramRun run = run_program(metric("T1\nG39\nX5.Y5.\nM30\n"));
  EXPECT_THAT(run.diagnostics, Contains("p.exc:7:1: error[coordinate-missing]"));
}

TEST(CalibrationOrders, SayNothingInACheck) {
  const ProgramRun run = run_program(metric("T1\nG39X1.Y2.\nG39\nX5.Y5.\nM30\n"), with_coupon());
  EXPECT_THAT(run.diagnostics, IsEmpty());
  EXPECT_EQ(run.survey.calibrations.size(), 2U);
}

TEST(CalibrationOrders, MakeLaterHolesAsSureAsTheNewOffset) {
  CalibratingSource source;
  const ProgramRun run =
      run_program(metric("G34,1\nT1\nG38X1.Y1.\nG39X1.Y2.\nG38X1.Y1.\nG35X1.Y1.\nX5.Y5.\nM30\n"),
                  with_coupon(),
                  source);
  ASSERT_EQ(run.holes().size(), 3U);
  EXPECT_THAT(run.holes()[0].drill.cov_mm2, IsNearMatrix(um2(140), kRounding_mm2));
  // 4 of the picture and 25 of the fresh offset, which has not drifted.
  EXPECT_THAT(run.holes()[1].drill.cov_mm2, IsNearMatrix(um2(29), kRounding_mm2));
  EXPECT_THAT(run.holes()[2].drill.cov_mm2, IsNearMatrix(um2(29), kRounding_mm2));
}

TEST(CalibrationOrders, ANestedTargetUndoesTheOldOffset) {
  CalibratingSource source;
  const ProgramRun run =
      run_program(metric("G34,1\nG35X1.Y1.\nG39X1.Y2.\nG45X2.Y2.\nT1\nX5.Y5.\nG47\nX5.Y5.\nM30\n"),
                  with_coupon(),
                  source);
  ASSERT_EQ(run.holes().size(), 2U);
  EXPECT_THAT(run.holes()[0].drill.cov_mm2, IsNearMatrix(um2(29), kRounding_mm2));
  EXPECT_THAT(run.holes()[1].drill.cov_mm2, IsNearMatrix(um2(140), kRounding_mm2));
}

TEST(CalibrationOrders, MustNotChangeTheOffsetInTheMiddleOfASeries) {
  for (const char* order : {"G39X1.Y2.", "G39", "$uvis,calib"}) {
    CalibratingSource source;
    const ProgramRun run = run_program(metric("G34,1\nG36X1.Y1.\nG36X9.Y1.\n" + std::string(order) +
                                              "\nG36X9.Y9.\nT1\nX5.Y5.\nM30\n"),
                                       with_coupon(),
                                       source);
    EXPECT_THAT(run.diagnostics, Contains(says(9, "error[series-unfinished]"))) << order;
    EXPECT_THAT(source.orders, IsEmpty()) << order;  // nothing was drilled for it
  }
}

TEST(CalibrationOrders, AreGivenInEveryCopy) {
  CalibratingSource source;
  run_program(metric("T1\nM25\nG39X1.Y2.\nM01\nM02X10.\nM08\nM30\n"), with_coupon(), source);
  ASSERT_EQ(source.orders.size(), 2U);
  EXPECT_EQ(source.orders[0].path, InstancePath{0});
  EXPECT_EQ(source.orders[1].path, InstancePath{1});
  EXPECT_EQ(source.orders[1].number, 1);
  EXPECT_EQ(source.orders[1].first_hole, position_mm<frame::Machine>(111, 202));
}

TEST(CalibrationOrders, AFailureEndsTheWalk) {
  CalibratingSource source;
  source.fails = true;
  const ProgramRun run =
      run_program(metric("G34,1\nG39X1.Y2.\nG35X1.Y1.\nT1\nX5.Y5.\nM30\n"), with_coupon(), source);
  EXPECT_THAT(run.diagnostics, ElementsAre("stage: error[device-stage]"));
  EXPECT_THAT(run.survey.measurements, IsEmpty());
  // Whatever the failure is called: nothing may be written from half a survey.
  EXPECT_FALSE(run.survey.is_complete());
}

TEST(CalibrationOrders, AreCounted) {
  CalibratingSource source;
  WalkOptions options = with_coupon();
  options.max_measurements = 3;
  const ProgramRun run = run_program(
      metric("T1\n$uvis,calib\n$uvis,calib\n$uvis,calib\n$uvis,calib\nM30\n"), options, source);
  EXPECT_EQ(source.orders.size(), 3U);
  EXPECT_THAT(run.texts, Contains(says(10, " 3 calibrations")));
}

TEST(CalibrationOrders, AreNamedByAnExplanation) {
  CalibratingSource source;
  const ProgramRun run =
      run_program(metric("G34,1\nG35X1.Y1.\nT1\nX5.Y5.\nG39X1.Y2.\nG35X1.Y1.\nX6.Y5.\nM30\n"),
                  with_coupon(),
                  source);
  const auto explain = [&](int line) {
    const WalkOptions options = with_coupon();
    Explainer explainer(
        {.line = line, .number = std::nullopt}, run.program, run.survey, options.uncertainty);
    DiagnosticLog log;
    execute(run.program, options, run.survey, explainer, log);
    return explainer.text();
  };
  EXPECT_THAT(explain(9), Not(HasSubstr("that G39")));
  EXPECT_THAT(
      explain(12),
      HasSubstr("measured with the spindle-camera offset (45.000000, -3.000000) mm that G39 "
                "in line 10 gave"));
  // sqrt(29) um in all, of which the offset is 5.
  EXPECT_THAT(explain(12), HasSubstr("sigma (5.385, 5.385) um"));
  EXPECT_THAT(explain(12), HasSubstr("spindle-camera offset       5.000    5.000    86.2"));
  EXPECT_THAT(explain(9), HasSubstr("spindle-camera offset      10.000   10.000    71.4"));
}

// --- what is written -----------------------------------------------------------------------------

TEST(CalibrationJson, OfAnOrderIsItsRequest) {
  CalibrationOrder order;
  order.number = 2;
  order.line = 7;
  order.command = "G39";
  order.path = {0, 1};
  order.first_hole = position_mm<frame::Machine>(101.5, 202);
  order.zoom = 3;
  EXPECT_EQ(to_json(order),
            R"({"calibration":2,"line":7,"command":"G39","path":[0,1],"first_hole":[101.5,202],)"
            R"("zoom":3})");
}

TEST(CalibrationJson, MeasurementsAndCalibrationsStandInTheirOrder) {
  CalibratingSource source;
  const ProgramRun run = run_program(
      metric("G34,1\nG39X1.Y2.\nG35X1.Y1.\nG39\nT1\nX5.Y5.\nM30\n"), with_coupon(), source);
  const std::string lines = measurement_lines(run.survey);
  EXPECT_TRUE(lines.starts_with(
      R"({"calibration":0,"line":7,"command":"G39","path":[],"first_hole":[101,202],)"
      R"("offset":[45,-3],"cov":[2.5e-05,0,2.5e-05],"text":"found"})"
      "\n{\"seq\":0,"))
      << lines;
  EXPECT_TRUE(lines.ends_with(R"({"calibration":1,"line":9,"command":"G39","path":[],)"
                              R"("offset":[45,-3],"cov":[2.5e-05,0,2.5e-05],"text":"found"})"
                              "\n"))
      << lines;
}

}  // namespace
}  // namespace panelcal
