// SPDX-License-Identifier: Apache-2.0
// The weights of a bending's strengths, and the growth of ellipses where few equations tell them,
// against closed forms.
#include "calib/panel/smoothing.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

using Eigen::Matrix2d;
using Eigen::VectorXd;

TEST(Smoothing, WeighsAStillPanelAsThePriorOfItsShareAsks) {
  // Six equations without a deviation: the likelihood of a share u is (1 - u)^3. With the prior, a
  // Beta distribution of 1/2 and 1/4, that is one of 1/2 and 13/4, whose mean is 2/15; a panel that
  // is not bent has the evidence 1. Shares below 0.005 % are left out, 0.3 % of the prior.
  const Smoothing found = weigh_strengths(VectorXd::Zero(6), VectorXd::Constant(6, 0.7));
  const double bent = 0.9 * std::beta(0.5, 3.25) / std::beta(0.5, 0.25);
  const double share = bent / (bent + 0.1) * 2 / 15;
  for (const double s : found.mean_shrinkage()) EXPECT_NEAR(s, share, 0.01 * share);
  EXPECT_NEAR(found.weight[0], 0.1 / (bent + 0.1), 0.01);
}

TEST(Smoothing, KnowsThatALargeBendingMayBeLargerThanItShows) {
  // Six equations far beyond the noise: the likelihood s^-3 exp(-q / 2 s) with the prior's tail
  // s^(-5/4) is an inverse gamma distribution of 6.5 degrees of freedom, whose mean is q / 4.5. A
  // share whose prior is uniform gives q / 6.
  const double q = 6 * 1e4;
  const Smoothing found = weigh_strengths(VectorXd::Constant(6, 1e2), VectorXd::Ones(6));
  EXPECT_NEAR(found.weight.dot(found.strength) / q, 1 / 4.5, 0.01);
}

/// Of a strength whose inverse has a chi square distribution of f degrees of freedom.
double growth_of_inverse_gamma(double f, const Matrix2d& form) {
  constexpr int kParts = 4000;
  std::vector<Matrix2d> bent;
  VectorXd weight(kParts);
  for (int k = 0; k < kParts; ++k) {
    const double x = 60 * (k + 0.5) / kParts;  // f / s
    bent.emplace_back(f / x * form);
    weight[k] = std::exp((0.5 * f - 1) * std::log(x) - 0.5 * x);
  }
  return growth_to_95_percent(Matrix2d::Zero(), bent, weight / weight.sum());
}

TEST(Smoothing, EllipsesOfABendingGrowAsHotellingsDo) {
  Matrix2d form;
  form << 4, 1, 1, 2;
  for (const double f : {4.0, 6.0, 12.0}) {
    const double hotelling = (f - 2) * (std::pow(0.05, -2 / f) - 1) / (-2 * std::log(0.05));
    EXPECT_NEAR(growth_of_inverse_gamma(f, form), hotelling, 2e-3) << f;
  }
}

TEST(Smoothing, EllipsesOfAKnownStrengthDoNotGrow) {
  const std::vector<Matrix2d> bent(3, Matrix2d::Identity());
  const VectorXd weight = VectorXd::Constant(3, 1.0 / 3);
  EXPECT_NEAR(growth_to_95_percent(Matrix2d::Identity(), bent, weight), 1, 1e-6);
}

TEST(Smoothing, EllipsesNeverShrink) {
  // One strength in fifty has all the variance: 95 % lie near, but a bending may be that strong.
  const std::vector<Matrix2d> bent{Matrix2d::Zero(), 50 * Matrix2d::Identity()};
  const VectorXd weight = Eigen::Vector2d(0.98, 0.02);
  EXPECT_NEAR(growth_to_95_percent(0.1 * Matrix2d::Identity(), bent, weight), 1, 1e-6);
}

}  // namespace
}  // namespace panelcal::internal
