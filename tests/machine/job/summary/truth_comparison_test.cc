// SPDX-License-Identifier: Apache-2.0
#include "machine/job/summary/truth_comparison.h"

#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/statistics/random.h"
#include "program/walk/walk.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

Truth shifted_panel() {
  Truth truth;
  truth.panel = Transform<frame::Actual, frame::Nominal>(Eigen::Matrix2d::Identity(),
                                                         Eigen::Vector2d(0.3, 0.4));
  truth.instances[{1}] =
      Transform<frame::Actual, frame::Nominal>(Eigen::Matrix2d::Identity(), Eigen::Vector2d(0, 0));
  return truth;
}

Drill hole(double x_mm, double corrected_x_mm) {
  return Drill{{position_mm<frame::Nominal>(x_mm, 0),
                position_mm<frame::Actual>(corrected_x_mm, 0),
                displacement_mm<frame::Machine>(corrected_x_mm, 0),
                position_mm<frame::Machine>(corrected_x_mm, 0),
                1e-6 * Eigen::Matrix2d::Identity()},
               1};
}

TEST(TruthComparison, MeasuresErrorWithAndWithoutCorrection) {
  const Truth truth = shifted_panel();
  TruthComparison comparison(truth);
  comparison.put({1, {}, hole(10, 10.3)});
  EXPECT_NEAR(comparison.all().uncorrected.max().in_mm(), 0.5, 1e-12);
  EXPECT_NEAR(comparison.all().corrected.max().in_mm(), 0.4, 1e-12);
}

TEST(TruthComparison, DrillsWhereAStageThatErrsStands) {
  Truth truth = shifted_panel();
  truth.table.emplace().scale_x_ppm = 1000;
  TruthComparison comparison(truth);
  // Work zero is at (100, 0); told 11 mm from there, the stage stands at 111.111 mm.
  Drill drill = hole(10, 10.3);
  drill.commanded = displacement_mm<frame::Machine>(11, 0);
  drill.actual = position_mm<frame::Machine>(111, 0);
  comparison.put({1, {}, drill});
  EXPECT_NEAR(comparison.all().corrected.max().in_mm(), std::hypot(11.111 - 10.3, 0.4), 1e-12);
  EXPECT_NEAR(comparison.all().uncorrected.max().in_mm(), std::hypot(10.110 - 10.3, 0.4), 1e-12);
}

TEST(TruthComparison, TakesTheBoardOfTheHolesPath) {
  const Truth truth = shifted_panel();
  TruthComparison comparison(truth);
  const std::vector<int> path = {1};
  comparison.put({1, path, hole(10, 10.003)});
  EXPECT_NEAR(comparison.all().corrected.max().in_um(), 3, 1e-9);
}

TEST(TruthComparison, NormalizesByThePredictedCovariance) {
  const Truth truth = shifted_panel();
  TruthComparison comparison(truth);
  const std::vector<int> path = {1};
  comparison.put({1, path, hole(10, 10.002)});  // 2 sigma in one of two coordinates
  EXPECT_NEAR(comparison.mean_normalized_square(), 2, 1e-9);
}

/// A machine with errors of its own, which a simulated panel has none of.
MachineUncertainty imperfect() {
  MachineUncertainty machine;
  machine.stage_repeatability = um(2);
  machine.table_residual = um(3);
  machine.drill_wander = um(4);
  machine.spindle_camera_mm2 = 25e-6 * Eigen::Matrix2d::Identity();
  machine.drift_mm2 = 36e-6 * Eigen::Matrix2d::Identity();
  machine.camera(2, 2) = 0.0049;
  return machine;
}

/// Sees targets where truth has them, with an error of its pictures.
class NoisyCamera final : public MeasurementSource {
 public:
  NoisyCamera(const Truth& truth, std::function<Eigen::Vector2d()> error_mm)
      : truth_(truth), error_mm_(std::move(error_mm)) {}
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    Measurement measurement{.request = request, .status = MeasurementStatus::Found};
    measurement.measured = {
        truth_.panel(request.nominal) + displacement_mm<frame::Actual>(error_mm_()),
        1e-6 * Eigen::Matrix2d::Identity()};
    measurement.by_camera = CameraJacobian::Zero();
    (*measurement.by_camera)(0, 2) = 0.01;
    return measurement;
  }

 private:
  const Truth& truth_;
  std::function<Eigen::Vector2d()> error_mm_;
};

/// Of one job with targets and holes as in `body`, on a panel that lies shifted.
double normalized_square(const std::string& body, std::function<Eigen::Vector2d()> error_mm) {
  const Truth truth = shifted_panel();
  DiagnosticLog log;
  const Program program =
      load_program({"p.exc", "M48\nMETRIC,LZ\nT1C1.0F100\n%\nG34,1\n" + body + "M30\n"}, log);
  WalkOptions options;
  options.series_size = 2;
  options.uncertainty = imperfect();
  NoisyCamera camera(truth, std::move(error_mm));
  const Survey survey = panelcal::survey(program, options, camera, log);
  TruthComparison comparison(truth, survey, options.uncertainty);
  execute(program, options, survey, comparison, log);
  EXPECT_FALSE(log.has_errors());
  return comparison.mean_normalized_square();
}

/// 2 sigma of the picture in one of two coordinates, whatever else is in the holes' covariance.
TEST(TruthComparison, CountsOnlyWhatASimulationDraws) {
  const auto two_um = [] { return Eigen::Vector2d(0.002, 0); };
  EXPECT_NEAR(normalized_square("G35X0.Y0.\nT1\nX50.Y70.\n", two_um), 2, 1e-6);
  EXPECT_NEAR(normalized_square("T1\nG38X50.Y70.\n", two_um), 2, 1e-6) << "a hole at its target";
}

/// A program may measure what it has drilled itself: that lies where the spindle was.
TEST(TruthComparison, ComparesAHoleAtItsTargetWithTheTarget) {
  Truth truth = shifted_panel();
  truth.targets.push_back({.seq = 0,
                           .nominal = position_mm<frame::Nominal>(10, 0),
                           .actual = position_mm<frame::Actual>(10.001, 0)});
  const std::size_t i_measurement = 0;
  Origin origin;
  origin.i_measurement = i_measurement;
  TruthComparison comparison(truth);
  comparison.put({.line = 1, .path = {}, .what = hole(10, 10.003), .file = {}, .origin = &origin});
  EXPECT_NEAR(comparison.all().corrected.max().in_um(), 2, 1e-9);
}

/// Two targets with the noise that they state; the hole is halfway, so that its variance is half a
/// target's. The mean of n chi squares of two degrees over two scatters by 1 / sqrt(n).
TEST(TruthComparison, IsOneOverManyHonestJobs) {
  constexpr int kJobs = 400;
  Random random(2611);
  double sum = 0;
  for (int i = 0; i < kJobs; ++i) {
    sum += normalized_square("G36X0.Y0.\nG36X80.Y0.\nT1\nX40.Y0.\n", [&] {
      const double x_mm = 0.001 * random.normal();
      return Eigen::Vector2d(x_mm, 0.001 * random.normal());
    });
  }
  EXPECT_NEAR(sum / kJobs, 1, 4 / std::sqrt(kJobs));
}

TEST(TruthComparison, SumsUpAsTheTradeDoes) {
  const Truth truth = shifted_panel();
  TruthComparison comparison(truth);
  const std::vector<int> path = {1};
  for (const double off_mm : {0.010, 0.014}) comparison.put({1, path, hole(10, 10 + off_mm)});
  const RadialFigures radial = comparison.by_tool().at(1).corrected.radial();
  EXPECT_NEAR(radial.mean().in_um(), 12, 1e-6);
  EXPECT_NEAR(radial.mean_plus_3_sigma().in_um(), 18, 1e-5);
}

TEST(TruthComparison, CountsByTool) {
  const Truth truth = shifted_panel();
  TruthComparison comparison(truth);
  for (int i = 0; i < 3; ++i) comparison.put({1, {}, hole(i, i)});
  EXPECT_EQ(comparison.by_tool().at(1).corrected.n, 3);
  EXPECT_NE(comparison.summary().find("T1"), std::string::npos);
}

}  // namespace
}  // namespace panelcal
