// SPDX-License-Identifier: Apache-2.0
// Is the uncertainty of several pictures the real one? Simulated machine, errors against truth.
#include <cmath>
#include <string>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "tests/machine/one_target.h"

namespace panelcal {
namespace {

using test::kShaken;
using ViewHonesty = test::OneTargetTest;

/// The same in many draws of noise: mean of e^T cov^-1 e / 2.
double mean_squared_error(SimMachine& machine, MeasurementRequest request, int n) {
  double sum = 0;
  const Position<frame::Actual> truth = machine.truth().targets.front().actual;
  for (int i = 0; i < n; ++i) {
    request.seq = i;  // draws other noise
    const auto m = machine.measure(request);
    EXPECT_TRUE(m) << m.error().text();
    EXPECT_EQ(m->status, MeasurementStatus::Found) << m->reason;
    if (!m || m->status != MeasurementStatus::Found) return 0;
    const Eigen::Vector2d error_mm = (m->measured.position - truth).in_mm();
    sum += error_mm.dot(m->measured.cov.ldlt().solve(error_mm)) / 2;
  }
  return sum / n;
}

TEST_F(ViewHonesty, CovarianceOfFourViewsIsTheRealOne) {
  constexpr int kTrials = 60;
  set_up({.vision = "search_radius_mm = 0.9\n",
          .camera = "",
          .sim = std::string(kShaken),
          .orders = "G34,1,6.0"});
  SimMachine machine = this->machine();
  const Measurement first = measure(machine);
  const double single_mm2 = [&] {
    MeasurementRequest one = first.request;
    one.settings.delta.reset();
    one.expected = one.expected + displacement_mm<frame::Actual>(6, 0);
    return machine.measure(one)->measured.cov.trace();
  }();
  EXPECT_NEAR(first.measured.cov.trace() / single_mm2, 0.25, 0.05);
  // A mean of 120 squares: four sigmas.
  EXPECT_NEAR(mean_squared_error(machine, first.request, kTrials), 1, 4 * std::sqrt(1.0 / kTrials));
}

TEST_F(ViewHonesty, InspectionsOfNoiseAreAveragedWithTheirScatter) {
  constexpr int kInspections = 25;
  set_up({.vision = "", .camera = "", .sim = std::string(kShaken), .orders = "G34,1"});
  SimMachine machine = this->machine();
  MeasurementRequest request = measure(machine).request;
  const double one_mm2 = machine.measure(request)->measured.cov.trace();
  request.settings.inspections = kInspections;
  const auto many = machine.measure(request);
  ASSERT_TRUE(many) << many.error().text();
  ASSERT_TRUE(many->scatter);
  EXPECT_NEAR(many->measured.cov.trace() / one_mm2, 1.0 / kInspections, 0.2 / kInspections);
  // Four sigmas of a standard deviation of 25.
  EXPECT_NEAR(many->scatter->in_mm().norm() / std::sqrt(one_mm2), 1, 4 / std::sqrt(2 * 48.0));
}

TEST_F(ViewHonesty, WeaveIsNotAveragedAway) {
  constexpr int kTrials = 20;
  double sum = 0;
  double ratio = 0;
  for (int i = 1; i <= kTrials; ++i) {
    set_up({.vision = "", .camera = "", .sim = "weave_amplitude = 0.06\n", .orders = "G34,1"});
    config_.sim->seed = static_cast<std::uint64_t>(i);  // other weave
    SimMachine machine = this->machine();
    MeasurementRequest request = measure(machine).request;
    const auto one = machine.measure(request);
    request.settings.inspections = 9;
    const auto nine = machine.measure(request);
    ASSERT_TRUE(nine && nine->status == MeasurementStatus::Found);
    const Eigen::Vector2d error_mm =
        (nine->measured.position - machine.truth().targets.front().actual).in_mm();
    sum += error_mm.dot(nine->measured.cov.ldlt().solve(error_mm)) / 2;
    ratio += nine->measured.cov.trace() / one->measured.cov.trace();
  }
  RecordProperty("chi_square", std::to_string(sum / kTrials));
  RecordProperty("covariance_ratio", std::to_string(ratio / kTrials));
  // Independent errors would have made 1/9 of it, and chi-squares several times too large. How
  // careful the covariance of a single fit on weave is, is not this test's matter.
  EXPECT_GT(ratio / kTrials, 1.5 / 9);
  EXPECT_LT(sum / kTrials, 1 + 4 / std::sqrt(kTrials));
}

}  // namespace
}  // namespace panelcal
