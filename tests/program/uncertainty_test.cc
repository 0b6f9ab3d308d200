// SPDX-License-Identifier: Apache-2.0
// From the measurements and the machine's own figures to the covariance of holes and routs.
#include <string>

#include "program/judge/explain.h"
#include "program/judge/place_budget.h"
#include <gmock/gmock.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::IsNearMatrix;
using test::metric;
using testing::HasSubstr;
using testing::Not;

constexpr double kUm2 = 1e-6;  // in mm^2
const Eigen::Matrix2d kOne = Eigen::Matrix2d::Identity();
/// Rounding of sums of some micrometres squared.
constexpr double kRounding_mm2 = 1e-16;

/// Every target where it is nominally, sigma 1 um, seen so far from the optical axis that 1 px of
/// error in the axis's x is 10 um.
class CameraSource final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    Measurement measurement{.request = request, .status = MeasurementStatus::Found};
    measurement.measured = {request.expected, kUm2 * kOne};
    measurement.by_camera = CameraJacobian::Zero();
    (*measurement.by_camera)(0, 2) = 0.01;
    return measurement;
  }
};

/// Detector 1, stage 2, table 3, wander 4, offset 5, drift 6 um, and in x 0.7 um by the axis.
WalkOptions all_terms() {
  WalkOptions options;
  options.series_size = 2;
  options.uncertainty.stage_repeatability = um(2);
  options.uncertainty.table_residual = um(3);
  options.uncertainty.drill_wander = um(4);
  options.uncertainty.spindle_camera_mm2 = 25 * kUm2 * kOne;
  options.uncertainty.drift_mm2 = 36 * kUm2 * kOne;
  options.uncertainty.camera(2, 2) = 0.0049;
  return options;
}

Eigen::Matrix2d diagonal_um2(double xx, double yy) {
  return kUm2 * Eigen::Vector2d(xx, yy).asDiagonal();
}

TEST(Uncertainty, OfAHoleUnderOneTargetIsTheSumOfAllTerms) {
  // At the target 1 + 4 + 9, shared 25 + 36, at the hole 4 + 9 + 16.
  CameraSource source;
  const auto run =
      test::run_program(metric("G34,1\nG35X0.Y0.\nT1\nX50.Y70.\nM30\n"), all_terms(), source);
  ASSERT_EQ(run.holes().size(), 1U);
  EXPECT_THAT(run.holes()[0].drill.cov_mm2, IsNearMatrix(diagonal_um2(104.49, 104), kRounding_mm2));
}

TEST(Uncertainty, OfTwoTargetsAveragesOnlyWhatIsTheirOwn) {
  // Halfway between two targets the turn does not count: 14 / 2, and the rest as it was.
  CameraSource source;
  const auto run = test::run_program(
      metric("G34,1\nG36X0.Y0.\nG36X80.Y0.\nT1\nX40.Y0.\nM30\n"), all_terms(), source);
  ASSERT_EQ(run.holes().size(), 1U);
  EXPECT_THAT(run.holes()[0].drill.cov_mm2, IsNearMatrix(diagonal_um2(97.49, 97), kRounding_mm2));
}

TEST(Uncertainty, OfANestedTargetHidesTheBaseAndSharesTheCamera) {
  // The nested target sees the base's error and the axis's: only its own 14 remain, 0.49 once.
  CameraSource source;
  const auto run = test::run_program(
      metric("G34,1\nG35X0.Y0.\nG45X10.Y10.\nT1\nX50.Y70.\nM30\n"), all_terms(), source);
  ASSERT_EQ(run.holes().size(), 1U);
  EXPECT_THAT(run.holes()[0].drill.cov_mm2, IsNearMatrix(diagonal_um2(104.49, 104), kRounding_mm2));
}

TEST(Uncertainty, OfAHoleAtItsOwnTargetIsThatOfTheTargetAndTheHole) {
  CameraSource source;
  const auto run = test::run_program(metric("G34,1\nT1\nG38X50.Y70.\nM30\n"), all_terms(), source);
  ASSERT_EQ(run.holes().size(), 1U);
  EXPECT_THAT(run.holes()[0].drill.cov_mm2, IsNearMatrix(diagonal_um2(104.49, 104), kRounding_mm2));
}

TEST(Uncertainty, OfRoutsIsThatOfHoles) {
  CameraSource source;
  const auto run = test::run_program(
      metric("G34,1\nG35X0.Y0.\nT1\nG00X1.Y1.\nM15\nG01X9.\nG02X9.Y3.A5.\nM17\nG05\nM30\n"),
      all_terms(),
      source);
  ASSERT_GE(run.executed.routs().size(), 2U);
  for (const Rout& rout : run.executed.routs()) {
    EXPECT_THAT(rout.cov_mm2, IsNearMatrix(diagonal_um2(104.49, 104), kRounding_mm2));
  }
}

TEST(Uncertainty, IsUnknownWithoutACorrection) {
  CameraSource source;
  const auto run = test::run_program(
      metric("G34,1\nG35X0.Y0.\nT1\nX1.Y1.\nG37\nX2.Y2.\nM30\n"), all_terms(), source);
  ASSERT_EQ(run.holes().size(), 2U);
  EXPECT_GT(run.holes()[0].drill.cov_mm2(0, 0), 0);
  EXPECT_EQ(run.holes()[1].drill.cov_mm2, Eigen::Matrix2d::Zero());
}

TEST(Uncertainty, AMeasurementKeepsThePicturesCovariance) {
  CameraSource source;
  const auto run =
      test::run_program(metric("G34,1\nG35X0.Y0.\nT1\nX1.Y1.\nM30\n"), all_terms(), source);
  EXPECT_EQ(run.survey.measurements.at(0).measured.cov, kUm2 * kOne);
  EXPECT_THAT(run.survey.series.at(0).base->pairs[0].measured.cov,
              IsNearMatrix(14 * kUm2 * kOne, kRounding_mm2));
}

TEST(Uncertainty, LayersOfOneTargetShareTheTable) {
  // Two arrivals: (1 + 4) / 2, and 9 as it is. Shared and at the hole 61 + 29.
  WalkOptions options = all_terms();
  options.sieb_meyer.measurement_mode = 2;
  CameraSource source;
  const auto run = test::run_program(
      "%%5000\nX10.Y10.G32\nX10.Y10.G33\nG31\nX5.Y5.T1\n$\nT1D1.\n$\n", options, source);
  ASSERT_EQ(run.holes().size(), 1U) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(run.holes()[0].drill.cov_mm2,
              IsNearMatrix(diagonal_um2(101.99, 101.5), kRounding_mm2));
  EXPECT_EQ(run.survey.series.at(0).base->pairs[0].n_arrivals, 2);
}

TEST(Uncertainty, AZoomHasErrorsOfItsOwn) {
  // Two targets by one camera: 0.49 comes through whole. By two of equal quality: half of it.
  WalkOptions options = all_terms();
  options.uncertainty.zooms[2] = options.uncertainty.camera;
  CameraSource source;
  const auto run = test::run_program(
      metric("G34,1\nG36X0.Y0.\n$uvis,zoom,2\nG36X80.Y0.\nT1\nX40.Y0.\nM30\n"), options, source);
  ASSERT_EQ(run.holes().size(), 1U) << testing::PrintToString(run.diagnostics);
  EXPECT_THAT(run.holes()[0].drill.cov_mm2, IsNearMatrix(diagonal_um2(97.245, 97), kRounding_mm2));
}

/// Keeps the budget of every place, and its covariance.
class BudgetSink final : public OperationSink {
 public:
  BudgetSink(const Survey& survey, const MachineUncertainty& machine)
      : survey_(survey), machine_(machine) {}
  void put(const Operation& operation) override {
    const auto* drill = std::get_if<Drill>(&operation.what);
    if (drill == nullptr) return;
    const auto budget = error_budget(budget_place(*drill, *operation.origin), survey_, machine_);
    ++n_holes;
    EXPECT_THAT(total_mm2(budget), IsNearMatrix(drill->cov_mm2, kRounding_mm2)) << n_holes;
  }
  int n_holes = 0;

 private:
  const Survey& survey_;
  const MachineUncertainty& machine_;
};

TEST(Uncertainty, BudgetsOfAllHolesAddUpToTheirCovariances) {
  WalkOptions options = all_terms();
  options.scaling = ReferenceScaling{.x = 1.05, .y = 0.95};
  CameraSource source;
  DiagnosticLog log;
  const Program program = load_program(
      {"p.exc",
       metric("G34,1\nT1\nX9.Y9.\nG36X0.Y0.\nG36X80.Y5.\nM25\nG46X10.Y10.\nG46X20.Y40.\nX15.Y5.\n"
              "G48X3.Y3.\nM01\nM02X50.Y10.\nM08\nM60\nX70.Y33.\nM30\n")},
      log);
  const Survey survey = panelcal::survey(program, options, source, log);
  ASSERT_FALSE(log.has_errors()) << log.kept().front().text();
  BudgetSink sink(survey, options.uncertainty);
  execute(program, options, survey, sink, log);
  EXPECT_EQ(sink.n_holes, 6);
}

std::string explained(const std::string& text, const WalkOptions& options) {
  CameraSource source;
  DiagnosticLog log;
  const Program program = load_program({"p.exc", text}, log);
  const Survey survey = panelcal::survey(program, options, source, log);
  EXPECT_FALSE(log.has_errors()) << log.kept().front().text();
  Explainer explainer(*parse_explain_choice("1"), program, survey, options.uncertainty);
  execute(program, options, survey, explainer, log);
  return explainer.text();
}

TEST(Uncertainty, IsExplainedTermByTerm) {
  // Variances 1, 0.49 (x only), 4, 9, 25, 36, 4, 9, 16: 208.49 in all.
  EXPECT_THAT(
      explained(metric("G34,1\nG35X0.Y0.\nT1\nX50.Y70.\nM30\n"), all_terms()),
      HasSubstr("  corrected   (50.000000, 70.000000) mm, sigma (10.222, 10.198) um\n"
                "  budget                      sigma x     y um share %  common to\n"
                "    detector                    1.000    1.000     1.0  holes of one fit\n"
                "    camera calibration          0.700    0.000     0.2  holes of one camera\n"
                "    stage at the targets        2.000    2.000     3.8  holes of one fit\n"
                "    table at the targets        3.000    3.000     8.6  holes of one fit\n"
                "    spindle-camera offset       5.000    5.000    24.0  all holes\n"
                "    its drift                   6.000    6.000    34.5  all holes\n"
                "    stage at the hole           2.000    2.000     3.8  this hole alone\n"
                "    table at the hole           3.000    3.000     8.6  this hole alone\n"
                "    drill wander                4.000    4.000    15.3  this hole alone\n"
                "    total                      10.222   10.198   100.0\n"
                "  work zero"));
}

TEST(Uncertainty, ExplainsWhatNobodyStatedAndAHoleAtItsTarget) {
  EXPECT_THAT(
      explained(metric("G34,1\nT1\nG38X5.Y7.\nM30\n"), {}),
      testing::AllOf(
          HasSubstr("  correction  none: G38 target 0 was measured at (5.000000, 7.000000) mm\n"),
          HasSubstr("    not stated: camera calibration, stage at the targets, table at the "
                    "targets, spindle-camera offset, its drift, stage at the hole, table at "
                    "the hole, drill wander\n")));
  EXPECT_THAT(explained(metric("T1\nX5.Y7.\nM30\n"), all_terms()), Not(HasSubstr("budget")));
}

}  // namespace
}  // namespace panelcal
