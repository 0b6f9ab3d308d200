// SPDX-License-Identifier: Apache-2.0
// Do fits to slots err as they say? Seeded draws around known truth.
#include <cmath>

#include "calib/panel/fit.h"
#include <Eigen/Cholesky>
#include <gmock/gmock.h>

#include "tests/calib/panel/synthetic_panel.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using internal::coefficients;
using internal::fit_raw;
using test::Coefficients;
using test::kAllModels;
using test::random_parameters;
using test::random_slots;
using test::RawFit;
using test::RawPair;

using Pairs = std::vector<RawPair>;

constexpr double kSigma_mm = 0.005;

class PanelFitSlotsStatistics : public testing::TestWithParam<PanelModel> {};

TEST_P(PanelFitSlotsStatistics, ErrAsTheirCovarianceSays) {
  constexpr int kTrials = 1000;
  const PanelModel model = GetParam();
  Random random(400 + parameter_count(model));
  const Coefficients truth = coefficients(model, random_parameters(random, model));
  const Pairs exact = random_slots(random, 3, 1, truth, kSigma_mm, false);
  const Eigen::Vector2d hole_mm(431, 77);
  double residual_chi_square = 0;
  double hole_chi_square = 0;
  int residual_dof = 0;
  Eigen::Vector2d hole_error_sum_mm = Eigen::Vector2d::Zero();
  Eigen::Matrix2d hole_cov_mm2 = Eigen::Matrix2d::Zero();
  for (int trial = 0; trial < kTrials; ++trial) {
    Pairs pairs = exact;
    for (RawPair& pair : pairs) {
      if (pair.axes == ObservedAxes::Both) {
        pair.to_mm += test::draw(random, pair.cov_mm2);
        continue;
      }
      const int axis = pair.axes == ObservedAxes::X ? 0 : 1;
      pair.to_mm[axis] += std::sqrt(pair.cov_mm2(axis, axis)) * random.normal();
    }
    const RawFit fit = *fit_raw(pairs, model).fit;
    residual_chi_square += fit.chi_square;
    residual_dof += fit.degrees_of_freedom;
    const TransformEstimate<frame::Actual, frame::Nominal> map = {
        Transform<frame::Actual, frame::Nominal>(fit.linear, fit.translation_mm), fit.cov};
    const auto hole = map(position_mm<frame::Nominal>(hole_mm));
    const Eigen::Vector2d error_mm = hole.position.in_mm() - test::mapped(truth, hole_mm);
    hole_chi_square += error_mm.dot(hole.cov.llt().solve(error_mm));
    hole_error_sum_mm += error_mm;
    hole_cov_mm2 = hole.cov;
  }
  EXPECT_EQ(residual_dof, kTrials * (8 - parameter_count(model)));
  EXPECT_TRUE(test::chi_square_agrees(hole_chi_square, 2 * kTrials));
  EXPECT_TRUE(test::chi_square_agrees(residual_chi_square, residual_dof));
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_TRUE(test::mean_agrees(
        hole_error_sum_mm[axis] / kTrials, 0, std::sqrt(hole_cov_mm2(axis, axis)), kTrials));
  }
}

INSTANTIATE_TEST_SUITE_P(EveryModel,
                         PanelFitSlotsStatistics,
                         testing::ValuesIn(kAllModels),
                         [](const auto& model) { return std::string(name(model.param)); });

}  // namespace
}  // namespace panelcal
