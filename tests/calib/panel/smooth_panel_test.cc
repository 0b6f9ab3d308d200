// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/smooth_panel.h"

#include <array>
#include <limits>
#include <utility>

#include "calib/panel/system.h"
#include <Eigen/Dense>
#include <gmock/gmock.h>

#include "tests/calib/panel/bowed_panel.h"
#include "tests/calib/panel/synthetic_panel.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using internal::fit_raw;
using internal::fit_smooth_raw;
using internal::RawSmooth;
using test::affine_truth;
using test::Bow;
using test::bowed_pairs;
using test::Coefficients;
using test::RawPair;

constexpr double kSigma_mm = test::kBowedSigma_mm;

TEST(SmoothPanel, CarriesAnAffinePanelExactly) {
  Random random(71);
  const Coefficients truth = affine_truth(random);
  const auto fit = fit_smooth_raw(test::random_pairs(random, 12, truth, kSigma_mm, false));
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->chi_square, 0, 1e-12);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d p_mm = test::random_place(random);
    EXPECT_LT((fit->map_mm(p_mm) - test::mapped(truth, p_mm)).norm(), 1e-9);
    EXPECT_LT((fit->jacobian(p_mm) -
               (Eigen::Matrix2d() << truth[0], truth[1], truth[2], truth[3]).finished())
                  .norm(),
              1e-9);
  }
}

/// The strength that takes up a share of the data, the weights and the predictions from the
/// textbook's dense formulas: y ~ N(X a, C + s K), universal kriging, restricted likelihood.
struct Dense {
  MatrixXd k, x;
  VectorXd y, noise;
  VectorXd k_hole, x_hole;

  MatrixXd sigma(double s) const { return s * k + MatrixXd(noise.asDiagonal()); }
  double share(double s) const {
    const MatrixXd inverse = sigma(s).inverse();
    const MatrixXd gls = (x.transpose() * inverse * x).inverse();
    const MatrixXd left = inverse - inverse * x * gls * x.transpose() * inverse;
    const double n_free = static_cast<double>(y.size() - x.cols());
    return 1 - (MatrixXd(noise.asDiagonal()) * left).trace() / n_free;
  }
  double strength(double wanted) const {
    double low = -60, high = 60;
    for (int i = 0; i < 80; ++i) {
      (share(std::exp(0.5 * (low + high))) < wanted ? low : high) = 0.5 * (low + high);
    }
    return std::exp(low);
  }
  /// log restricted likelihood, mean and variance at the hole.
  std::array<double, 3> at(double s) const {
    const MatrixXd cov = sigma(s);
    const MatrixXd inverse = cov.inverse();
    const MatrixXd information = x.transpose() * inverse * x;
    const VectorXd a = information.ldlt().solve(x.transpose() * inverse * y);
    const VectorXd r = y - x * a;
    const VectorXd lever = x_hole - s * x.transpose() * inverse * k_hole;
    return {-0.5 * (std::log(cov.determinant()) + std::log(information.determinant()) +
                    r.dot(inverse * r)),
            x_hole.dot(a) + s * k_hole.dot(inverse * r),
            -s * s * k_hole.dot(inverse * k_hole) + lever.dot(information.inverse() * lever)};
  }
};

TEST(SmoothPanel, AveragesKrigingOverItsStrengths) {
  // With equal round noises x and y are kriged apart; their strength is common, so both count for
  // it. The covariance r^2 log r is positive only up to affine maps: a plain large constant and
  // slopes added to it change nothing and make it invertible.
  Random random(72);
  constexpr int kN = 9;
  const Bow bow(random, 0.01);
  std::vector<RawPair> pairs;
  for (int i = 0; i < kN; ++i) {
    const Eigen::Vector2d from_mm = test::random_place(random);
    const Eigen::Matrix2d cov_mm2 =
        std::pow(0.004 + 0.001 * (i % 3), 2) * Eigen::Matrix2d::Identity();
    pairs.push_back({from_mm, from_mm + bow(from_mm) + test::draw(random, cov_mm2), cov_mm2});
  }
  const Eigen::Vector2d hole_mm(180, 310);
  const auto plate = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const double r = (a - b).norm() / 100;
    const double even = 40 + 10 * a.dot(b) / 1e4;
    return even + (r > 0 ? r * r * std::log(r) : 0);
  };
  std::array<Dense, 2> axes;
  for (int axis = 0; axis < 2; ++axis) {
    Dense& d = axes[static_cast<std::size_t>(axis)];
    d.k.resize(kN, kN);
    d.x.resize(kN, 3);
    d.y.resize(kN);
    d.noise.resize(kN);
    d.k_hole.resize(kN);
    d.x_hole = Eigen::Vector3d(1, hole_mm.x() / 100, hole_mm.y() / 100);
    for (int i = 0; i < kN; ++i) {
      const RawPair& pair = pairs[static_cast<std::size_t>(i)];
      for (int j = 0; j < kN; ++j) {
        d.k(i, j) = plate(pair.from_mm, pairs[static_cast<std::size_t>(j)].from_mm);
      }
      d.x.row(i) << 1, pair.from_mm.transpose() / 100;
      d.y[i] = pair.to_mm[axis] - pair.from_mm[axis];
      d.noise[i] = pair.cov_mm2(axis, axis);
      d.k_hole[i] = plate(pair.from_mm, hole_mm);
    }
  }
  constexpr int kSteps = 64;
  std::array<double, kSteps + 1> weight;
  std::array<Eigen::Vector2d, kSteps + 1> mean, variance;
  double best = -1e300;
  for (int step = 0; step <= kSteps; ++step) {
    const auto i = static_cast<std::size_t>(step);
    // Even in the log odds of the share, from -10 to 16, by midpoints; the share is a Beta variate.
    const double odds = std::exp(-10 + 26 * (step - 0.5) / kSteps);
    const double share = odds / (1 + odds);
    const double s = step == 0 ? 0 : axes[0].strength(share);
    const double density = std::sqrt(share) * std::pow(1 / (1 + odds), 0.25) / std::beta(0.5, 0.25);
    weight[i] = std::log(step == 0 ? 0.1 : 0.9 * density * 26 / kSteps);
    for (int axis = 0; axis < 2; ++axis) {
      const auto [likelihood, m, v] = axes[static_cast<std::size_t>(axis)].at(s);
      weight[i] += likelihood;
      mean[i][axis] = m;
      variance[i][axis] = v + s * plate(hole_mm, hole_mm);
    }
    best = std::max(best, weight[i]);
  }
  double sum = 0;
  Eigen::Vector2d expected = Eigen::Vector2d::Zero();
  for (double& w : weight) sum += w = std::exp(w - best);
  for (std::size_t i = 0; i <= kSteps; ++i) expected += weight[i] / sum * mean[i];
  Eigen::Vector2d expected_variance = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i <= kSteps; ++i) {
    expected_variance += weight[i] / sum * (variance[i] + (mean[i] - expected).cwiseAbs2());
  }

  const auto fit = fit_smooth_raw(pairs);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->map_mm(hole_mm) - hole_mm - expected).norm(), 1e-8);
  // What a straight panel's noise leaves is known; the rest grows, of both axes by one factor.
  const Eigen::Matrix3d information =
      axes[0].x.transpose() * axes[0].noise.cwiseInverse().asDiagonal() * axes[0].x;
  const double noise = axes[0].x_hole.dot(information.inverse() * axes[0].x_hole);
  const double growth = (fit->cov_mm2(hole_mm)(0, 0) - noise) / (expected_variance.x() - noise);
  EXPECT_GE(growth, 1 - 1e-4);
  EXPECT_LE(growth, 1.4);
  EXPECT_NEAR(fit->cov_mm2(hole_mm)(1, 1),
              noise + growth * (expected_variance.y() - noise),
              1e-4 * expected_variance.y());
}

TEST(SmoothPanel, SlopesAreThoseOfTheMap) {
  Random random(73);
  const auto fit = fit_smooth_raw(bowed_pairs(random, 20, affine_truth(random), Bow(random, 0.05)));
  ASSERT_TRUE(fit);
  constexpr double kStep_mm = 1e-3;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d p_mm = test::random_place(random);
    Eigen::Matrix2d expected;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step_mm = kStep_mm * Eigen::Vector2d::Unit(axis);
      expected.col(axis) =
          (fit->map_mm(p_mm + step_mm) - fit->map_mm(p_mm - step_mm)) / (2 * kStep_mm);
    }
    EXPECT_LT((fit->jacobian(p_mm) - expected).norm(), 1e-8);
  }
}

/// As for the affine models: chi square + 2 parameters predicts the chi square of the same targets
/// measured again, smoothing chosen by the data and all.
TEST(SmoothPanel, CriterionForetellsTheNextMeasurement) {
  constexpr int kTrials = 1000;
  Random random(74);
  for (const double bow_mm : {0.0, 0.005}) {
    const Coefficients truth = affine_truth(random);
    const Bow bow(random, bow_mm);
    auto exact = test::random_pairs(random, 10, truth, kSigma_mm, false);
    for (RawPair& pair : exact) pair.to_mm += bow(pair.from_mm);
    double sum = 0;
    double sum_of_squares = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      auto pairs = exact;
      for (RawPair& pair : pairs) pair.to_mm += test::draw(random, pair.cov_mm2);
      const RawSmooth fit = *fit_smooth_raw(pairs);
      double chi_square = 0;
      for (const RawPair& pair : exact) {
        const Eigen::Vector2d again_mm = pair.to_mm + test::draw(random, pair.cov_mm2);
        const Eigen::Vector2d miss_mm = again_mm - fit.map_mm(pair.from_mm);
        chi_square += (*internal::whitening(pair.cov_mm2) * miss_mm).squaredNorm();
      }
      sum += fit.criterion() - chi_square;
      sum_of_squares += std::pow(fit.criterion() - chi_square, 2);
    }
    const double sigma = std::sqrt(sum_of_squares / kTrials);
    EXPECT_TRUE(test::mean_agrees(sum / kTrials, 0, sigma, kTrials)) << bow_mm;
  }
}

/// Leave-one-out keeps the smoothing of all targets; a new fit to the others has its own.
TEST(SmoothPanel, LeavesOneOutNearlyAsRefittingDoes) {
  constexpr int kPanels = 20;
  Random random(77);
  double sum = 0;
  double sum_by_refit = 0;
  for (int i_panel = 0; i_panel < kPanels; ++i_panel) {
    const auto pairs = bowed_pairs(random, 15, affine_truth(random), Bow(random, 0.03));
    const RawSmooth fit = *fit_smooth_raw(pairs);
    ASSERT_TRUE(fit.left_out_rms_mm);
    sum += std::pow(*fit.left_out_rms_mm, 2);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      auto others = pairs;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
      const Eigen::Vector2d miss =
          pairs[i].to_mm - fit_smooth_raw(others)->map_mm(pairs[i].from_mm);
      sum_by_refit += miss.squaredNorm() / static_cast<double>(pairs.size());
    }
  }
  EXPECT_NEAR(std::sqrt(sum / sum_by_refit), 1, 0.1);
}

TEST(SmoothPanel, TakesSlotsByWhatTheyShow) {
  Random random(78);
  const Coefficients truth = affine_truth(random);
  const auto pairs = test::random_slots(random, 5, 6, truth, kSigma_mm, true);
  const auto fit = fit_smooth_raw(pairs);
  ASSERT_TRUE(fit);
  ASSERT_TRUE(fit->left_out_rms_mm);
  EXPECT_LT(*fit->left_out_rms_mm, 10 * kSigma_mm);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_TRUE(fit->residuals_mm[i].allFinite());
    if (pairs[i].axes == ObservedAxes::X) {
      EXPECT_EQ(fit->residuals_mm[i].y(), 0);
    }
  }
  const Eigen::Matrix2d cov_mm2 = fit->cov_mm2({250, 200});
  EXPECT_TRUE(cov_mm2.allFinite());
  EXPECT_GT(cov_mm2.determinant(), 0);
}

TEST(SmoothPanel, RefusesWhatShowsNoBending) {
  Random random(79);
  const Coefficients truth = affine_truth(random);
  EXPECT_FALSE(fit_smooth_raw({}));
  EXPECT_FALSE(fit_smooth_raw(test::random_pairs(random, 5, truth, kSigma_mm, true)));
  EXPECT_FALSE(
      fit_smooth_raw(test::random_pairs(random, kMostSmoothTargets + 1, truth, kSigma_mm, true)));
  std::vector<RawPair> line;
  std::vector<RawPair> three_places;
  for (int i = 0; i < 9; ++i) {
    line.push_back(test::seen_exactly(10 * i, 20 * i));
    three_places.push_back(test::seen_exactly(100 * (i % 3), 50 * (i % 3 == 1)));
  }
  EXPECT_FALSE(fit_smooth_raw(line));
  EXPECT_FALSE(fit_smooth_raw(three_places));
  auto broken = test::random_pairs(random, 8, truth, kSigma_mm, true);
  broken[3].to_mm.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(fit_smooth_raw(broken));
  broken[3].to_mm.x() = 1;
  broken[3].cov_mm2.setZero();
  EXPECT_FALSE(fit_smooth_raw(broken));
}

TEST(SmoothPanel, SpeaksInFrames) {
  Random random(80);
  std::vector<TargetPair<frame::Base, frame::Nominal>> pairs;
  for (const RawPair& raw : bowed_pairs(random, 12, affine_truth(random), Bow(random, 0.03))) {
    pairs.push_back({position_mm<frame::Nominal>(raw.from_mm),
                     {position_mm<frame::Base>(raw.to_mm), raw.cov_mm2}});
  }
  const auto fit =
      fit_smooth_panel(std::span<const TargetPair<frame::Base, frame::Nominal>>(pairs));
  ASSERT_TRUE(fit);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector2d fitted_mm = fit->map(pairs[i].nominal).in_mm();
    EXPECT_LT((pairs[i].measured.position.in_mm() - fitted_mm - fit->residuals_mm()[i]).norm(),
              1e-12);
  }
  EXPECT_GT(fit->parameters(), 6);
  EXPECT_DOUBLE_EQ(fit->criterion(), fit->chi_square() + 2 * fit->parameters());
  EXPECT_GT(fit->covariance(pairs[0].nominal).determinant(), 0);
}

TEST(SmoothPanel, AnswersLinearlyToItsTargets) {
  // With the smoothing held fast the estimate is sum of by_target_i measured_i, and affine maps are
  // carried as they are.
  Random random(81);
  const Coefficients truth = affine_truth(random);
  for (const double bow_mm : {0.0, 0.03}) {
    const auto pairs = bowed_pairs(random, 14, truth, Bow(random, bow_mm));
    const RawSmooth fit = *fit_smooth_raw(pairs);
    const Eigen::Vector2d p_mm = test::random_place(random);
    const internal::SmoothBasis basis = fit.basis_at(p_mm);
    Eigen::Vector2d of_measured = Eigen::Vector2d::Zero();
    Eigen::Vector2d of_affine = Eigen::Vector2d::Zero();
    Eigen::Matrix2d noise_mm2 = Eigen::Matrix2d::Zero();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Eigen::Matrix2d by_target = fit.by_target(basis, i);
      of_measured += by_target * pairs[i].to_mm;
      of_affine += by_target * test::mapped(truth, pairs[i].from_mm);
      noise_mm2 += by_target * pairs[i].cov_mm2 * by_target.transpose();
    }
    EXPECT_LT((of_measured - fit.map_mm(p_mm)).norm(), 1e-9);
    EXPECT_LT((of_affine - test::mapped(truth, p_mm)).norm(), 1e-9);
    // The unknown bending of the panel between its targets only adds to their noise.
    const Eigen::Matrix2d unknown_mm2 = fit.cov_mm2(p_mm) - noise_mm2;
    EXPECT_GE(unknown_mm2.trace(), 0);
    EXPECT_GE(unknown_mm2.determinant(), 0);
  }
}

TEST(SmoothPanel, HasTheAffineFitForItsAffinePart) {
  Random random(82);
  const auto pairs = bowed_pairs(random, 14, affine_truth(random), Bow(random, 0.03));
  const RawSmooth fit = *fit_smooth_raw(pairs);
  auto fitted = pairs;
  for (RawPair& pair : fitted) pair.to_mm = fit.map_mm(pair.from_mm);
  const auto of_targets = *fit_raw(pairs, PanelModel::Affine).fit;
  const auto of_fit = *fit_raw(fitted, PanelModel::Affine).fit;
  EXPECT_LT((of_targets.linear - of_fit.linear).norm(), 1e-10);
  EXPECT_LT((of_targets.translation_mm - of_fit.translation_mm).norm(), 1e-8);
  const Eigen::Matrix2Xd weights = fit.weights_of(of_targets.linear, of_targets.translation_mm);
  RawSmooth straight = fit;
  straight.weights = weights;
  const Eigen::Vector2d p_mm(-40, 310);
  EXPECT_LT((straight.map_mm(p_mm) - of_targets.linear * p_mm - of_targets.translation_mm).norm(),
            1e-10);
}

TEST(SmoothPanel, SeesThatItWouldFoldAPanel) {
  Random random(83);
  auto pairs = bowed_pairs(random, 14, affine_truth(random), Bow(random, 0.03));
  EXPECT_TRUE(internal::is_unfolded(*fit_smooth_raw(pairs), pairs));
  std::swap(pairs[2].to_mm, pairs[3].to_mm);
  EXPECT_FALSE(internal::is_unfolded(*fit_smooth_raw(pairs), pairs));
}

}  // namespace
}  // namespace panelcal
