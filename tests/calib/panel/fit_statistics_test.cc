// SPDX-License-Identifier: Apache-2.0
// Does the fit err as it says? Seeded draws around known truth.
#include "calib/panel/fit.h"
#include <Eigen/Cholesky>
#include <gmock/gmock.h>

#include "tests/calib/panel/synthetic_panel.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using test::chi_square_agrees;
using test::Coefficients;
using test::coefficients_of;
using test::kAllModels;
using test::mean_agrees;
using test::RawFit;
using test::RawPair;

constexpr int kTrials = 2000;
constexpr double kSigma_mm = 0.010;
constexpr int kTargets = 4;

class PanelFitStatistics : public testing::TestWithParam<PanelModel> {};

TEST_P(PanelFitStatistics, ErrsAsItsCovarianceSays) {
  const PanelModel model = GetParam();
  Random random(200 + parameter_count(model));
  const Coefficients truth = internal::coefficients(model, test::random_parameters(random, model));
  const Eigen::Vector2d hole_mm(431, 77);
  double residual_chi_square = 0;
  double hole_chi_square = 0;
  int residual_dof = 0;
  Eigen::Vector2d hole_error_sum_mm = Eigen::Vector2d::Zero();
  Eigen::Matrix2d hole_cov_mm2 = Eigen::Matrix2d::Zero();
  const std::vector<RawPair> exact = test::random_pairs(random, kTargets, truth, kSigma_mm, false);
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<RawPair> pairs = exact;
    for (RawPair& pair : pairs) pair.to_mm += test::draw(random, pair.cov_mm2);
    const RawFit fit = *internal::fit_raw(pairs, model).fit;
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
  EXPECT_TRUE(chi_square_agrees(hole_chi_square, 2 * kTrials));
  if (residual_dof > 0) {
    EXPECT_TRUE(chi_square_agrees(residual_chi_square, residual_dof));
  }
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_TRUE(mean_agrees(
        hole_error_sum_mm[axis] / kTrials, 0, std::sqrt(hole_cov_mm2(axis, axis)), kTrials));
  }
  RecordProperty("hole_chi_square_per_dof", testing::PrintToString(hole_chi_square / 2 / kTrials));
}

INSTANTIATE_TEST_SUITE_P(EveryModel,
                         PanelFitStatistics,
                         testing::ValuesIn(kAllModels),
                         [](const auto& model) { return std::string(name(model.param)); });

}  // namespace
}  // namespace panelcal
