// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/misfit.h"

#include <cmath>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "tests/calib/panel/synthetic_panel.h"

namespace panelcal {
namespace {

using MisfitPair = TargetPair<frame::Base, frame::Nominal>;
using MisfitFit = PanelFit<frame::Base, frame::Nominal>;

constexpr double kMisfitSigma_mm = 1e-3;

/// Six targets on a healthy panel, the fifth `wrong_mm` off in x, under a stretch.
std::vector<MisfitPair> six_targets(double wrong_mm) {
  std::vector<MisfitPair> pairs;
  for (const double y_mm : {0.0, 80.0}) {
    for (const double x_mm : {0.0, 50.0, 100.0}) {
      const double error_mm = pairs.size() == 4 ? wrong_mm : 0;
      pairs.push_back({position_mm<frame::Nominal>(x_mm, y_mm),
                       {position_mm<frame::Base>(x_mm + error_mm, y_mm),
                        kMisfitSigma_mm * kMisfitSigma_mm * Eigen::Matrix2d::Identity()}});
    }
  }
  return pairs;
}

MisfitFit fitted(const std::vector<MisfitPair>& pairs, PanelModel model = PanelModel::Stretch) {
  return fit_panel(std::span(pairs), model).fit.value();
}

TEST(Misfit, LeavesTargetsThatAgreeAsTheyAreStated) {
  MisfitFit fit = fitted(six_targets(0.002));
  const Eigen::Matrix<double, 6, 6> before = fit.map.cov;
  count_misfit(fit);
  EXPECT_EQ(fit.map.cov, before);
  EXPECT_TRUE(fit.misfit_cov.isZero(0));
}

/// Of f equations to spare: 2 F(2, f) is exceeded by f (0.05^(-2/f) - 1) in 5 %.
double hotelling(double f) {
  return f * (std::pow(0.05, -2 / f) - 1) / (-2 * std::log(0.05));
}

TEST(Misfit, GrowsByTheBirgeRatioOfAnEstimatedNoise) {
  MisfitFit fit = fitted(six_targets(0.1));
  const Eigen::Matrix<double, 6, 6> before = fit.map.cov;
  ASSERT_EQ(fit.degrees_of_freedom, 7);
  const double ratio2 = hotelling(7) * fit.chi_square / 7;
  ASSERT_GT(ratio2, 100);
  count_misfit(fit);
  EXPECT_TRUE(fit.map.cov.isApprox(ratio2 * before, 1e-12));
  EXPECT_TRUE((fit.map.cov - fit.misfit_cov).isApprox(before, 1e-6));
}

TEST(Misfit, LeavesTheChoiceOfTheModelOut) {
  MisfitFit fit = fitted(six_targets(0.1));
  const double ratio2 = hotelling(7) * fit.chi_square / 7;
  const Eigen::Matrix<double, 6, 6> of_targets = fit.map.cov;
  fit.choice_cov = 1e-3 * Eigen::Matrix<double, 6, 6>::Identity();
  fit.map.cov += fit.choice_cov;
  count_misfit(fit);
  EXPECT_TRUE(fit.map.cov.isApprox(ratio2 * of_targets + fit.choice_cov, 1e-9));
}

TEST(Misfit, SaysNothingWithoutAnEquationToSpare) {
  EXPECT_EQ(internal::misfit_excess(1e6, 0), 0);
  // p = 0.001 at 10.828 with one degree of freedom.
  EXPECT_EQ(internal::misfit_excess(10.82, 1), 0);
  EXPECT_NEAR(internal::misfit_excess(10.84, 1), 9.84, 1e-12);
}

/// From three equations on the scatter counts where one healthy series in 10 scatters so.
TEST(Misfit, CountsAScatterThatOneInTenHealthySeriesHas) {
  EXPECT_EQ(internal::misfit_excess(6.25, 3), 0);
  EXPECT_NEAR(internal::misfit_excess(6.26, 3), hotelling(3) * 6.26 / 3 - 1, 1e-12);
  EXPECT_EQ(internal::misfit_excess(12.01, 7), 0);
  EXPECT_NEAR(internal::misfit_excess(12.03, 7), hotelling(7) * 12.03 / 7 - 1, 1e-12);
}

TEST(Misfit, GrowsASmoothPanelEverywhere) {
  const std::vector<MisfitPair> pairs = six_targets(0.1);
  MisfitFit fit = fit_bent(std::span<const MisfitPair>(pairs)).fit.value();
  // A spline follows six targets; only more of them disagree with one.
  fit.chi_square = 120;
  fit.degrees_of_freedom = 8;
  const auto place = position_mm<frame::Nominal>(33, 47);
  const Eigen::Matrix2d before = fit.smooth->covariance(place);
  count_misfit(fit);
  EXPECT_TRUE(fit.smooth->covariance(place).isApprox(hotelling(8) * 15 * before, 1e-9));
}

}  // namespace
}  // namespace panelcal
