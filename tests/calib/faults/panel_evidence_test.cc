// SPDX-License-Identifier: Apache-2.0
#include "calib/faults/panel_evidence.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/calib/panel/synthetic_panel.h"

namespace panelcal::internal {
namespace {

/// The logarithm of N(v; 0, cov).
double log_normal(const Eigen::VectorXd& v, const Eigen::MatrixXd& cov) {
  const Eigen::LLT<Eigen::MatrixXd> root(cov);
  const Eigen::VectorXd white = root.matrixL().solve(v);
  const double log_root = root.matrixLLT().diagonal().array().log().sum();
  return -0.5 * white.squaredNorm() - log_root -
         0.5 * static_cast<double>(v.size()) * std::log(2 * std::numbers::pi);
}

std::vector<ToldTarget> random_targets(Random& random, int n) {
  std::vector<ToldTarget> targets;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector2d from(random.uniform(0, 300), random.uniform(0, 200));
    const Eigen::Vector2d to = from + 0.02 * Eigen::Vector2d(random.normal(), random.normal());
    targets.push_back({from, to, test::random_covariance(random, 0.005), ObservedAxes::Both});
  }
  return targets;
}

/// Measurements of a linear model are one large normal variable, whose covariance can be written
/// down: noise, plus the prior carried to the targets.
TEST(PanelEvidence, IsTheMarginalLikelihoodWrittenOut) {
  Random random(11);
  for (int trial = 0; trial < 50; ++trial) {
    const int n = 1 + trial % 6;
    const std::vector<ToldTarget> targets = random_targets(random, n);
    // Without rotation the model is linear.
    const PanelBelief belief{
        .offset_mm = 0.5, .rotation_rad = 0, .scale = 2e-4, .difference = 1e-4, .shear = 3e-4};
    Eigen::Vector2d center = Eigen::Vector2d::Zero();
    for (const ToldTarget& target : targets) center += target.from_mm / n;
    Eigen::MatrixXd design(2 * n, 5);
    Eigen::VectorXd v(2 * n);
    Eigen::MatrixXd cov = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    for (int i = 0; i < n; ++i) {
      const ToldTarget& target = targets[static_cast<std::size_t>(i)];
      const Eigen::Vector2d arm = target.from_mm - center;
      design.middleRows<2>(2 * i) << 1, 0, arm.x(), arm.x(), arm.y(), 0, 1, arm.y(), -arm.y(), 0;
      v.segment<2>(2 * i) = target.to_mm - target.from_mm;
      cov.block<2, 2>(2 * i, 2 * i) = target.cov_mm2;
    }
    Eigen::VectorXd prior(5);
    prior << 0.25, 0.25, 4e-8, 1e-8, 9e-8;
    cov += design * prior.asDiagonal() * design.transpose();
    const double expected = log_normal(v, cov);
    EXPECT_NEAR(
        evidence(targets, belief).log_likelihood, expected, 1e-6 * std::abs(expected) + 1e-6);
  }
}

/// The rotation's prior is integrated out by brute force: 4001 steps over six standard deviations.
TEST(PanelEvidence, IntegratesOverTheRotation) {
  Random random(12);
  std::vector<ToldTarget> targets = random_targets(random, 3);
  const double sigma_rad = 4e-3;
  for (ToldTarget& target : targets) target.to_mm = test::rotation(0.006) * target.from_mm;
  const PanelBelief belief{.offset_mm = 3, .rotation_rad = sigma_rad};
  double sum = 0;
  const double top = evidence(targets, belief).log_likelihood;
  constexpr int kSteps = 4000;
  const double step = 12 * sigma_rad / kSteps;
  for (int k = 0; k <= kSteps; ++k) {
    const double theta = -6 * sigma_rad + step * k;
    // Turned beforehand about the centre, as the story says.
    Eigen::Vector2d center = Eigen::Vector2d::Zero();
    for (const ToldTarget& target : targets) center += target.from_mm / 3;
    const Eigen::Matrix2d turn = test::rotation(theta);
    const Lie lie{turn, center - turn * center};
    const double given = evidence(targets, {.offset_mm = 3}, lie).log_likelihood;
    const double prior = std::exp(-0.5 * theta * theta / sigma_rad / sigma_rad) / sigma_rad /
                         std::sqrt(2 * std::numbers::pi);
    sum += std::exp(given - top) * prior * step;
  }
  EXPECT_NEAR(std::log(sum), 0, 2e-3);
}

/// The likeliest map is known where it was drawn, whichever way the panel lies.
TEST(PanelEvidence, FindsTheMapOfATurnedPanel) {
  Random random(13);
  std::vector<ToldTarget> targets = random_targets(random, 4);
  Eigen::Matrix2d truth = test::rotation(0.5 * std::numbers::pi + 0.003);
  for (ToldTarget& target : targets) target.to_mm = truth * target.from_mm + Eigen::Vector2d(5, 7);
  const Lie lie{test::rotation(0.5 * std::numbers::pi), Eigen::Vector2d::Zero()};
  const Evidence told = evidence(targets, {.offset_mm = 20, .rotation_rad = 0.01}, lie);
  EXPECT_LT((told.linear - truth).norm(), 1e-6);
  EXPECT_LT((told.translation_mm - Eigen::Vector2d(5, 7)).norm(), 1e-4);
}

/// A coordinate that a slot does not show may be no number, and the one that it shows counts as one
/// coordinate.
TEST(PanelEvidence, CountsSlotsByTheirCoordinate) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Eigen::Matrix2d cov;
  cov << 1e-4, kNan, kNan, kNan;
  const std::vector<ToldTarget> slot = {{{10, 20}, {10.3, kNan}, cov, ObservedAxes::X}};
  const double variance = 1e-4 + 0.25;
  const double expected = -0.5 * 0.09 / variance - 0.5 * std::log(2 * std::numbers::pi * variance);
  EXPECT_NEAR(evidence(slot, {.offset_mm = 0.5}).log_likelihood, expected, 1e-9);
}

TEST(PanelEvidence, BelievesHalfOfWhatLimitsAllow) {
  GateLimits limits;
  limits.offset = mm(1);
  limits.rotation = rad(0.004);
  limits.stretch_ppm = 600;
  const PanelBelief stretch = belief_of(limits, PanelModel::Stretch);
  EXPECT_NEAR(stretch.offset_mm, 0.5, 1e-12);
  EXPECT_NEAR(stretch.rotation_rad, 0.002, 1e-12);
  // Of sx = e + d: both halves together.
  EXPECT_NEAR(std::hypot(stretch.scale, stretch.difference), 300e-6, 1e-12);
  EXPECT_EQ(stretch.shear, 0);
  EXPECT_EQ(belief_of(limits, PanelModel::Rigid).scale, 0);
  EXPECT_EQ(belief_of(limits, PanelModel::Offset).rotation_rad, 0);
  EXPECT_GT(belief_of(limits, PanelModel::Affine).shear, 0);
}

}  // namespace
}  // namespace panelcal::internal
