// SPDX-License-Identifier: Apache-2.0
#include "calib/spindle/variance_components.h"

#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "calib/base/statistics/random.h"
#include "calib/spindle/restricted_likelihood.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::internal {
namespace {

/// Of quantities of the size of 1.
constexpr double kTight = 1e-7;

GroupedObservation observation(int group, const Eigen::Vector2d& value, double variance) {
  GroupedObservation one;
  one.group = group;
  one.value_mm = value;
  one.cov_mm2 = variance * Eigen::Matrix2d::Identity();
  one.design = Eigen::Matrix2d::Identity();
  return one;
}

Eigen::Vector2d draw(Random& random, double sigma_x, double sigma_y) {
  const double x = sigma_x * random.normal();
  return {x, sigma_y * random.normal()};
}

/// Groups of equal size about (5, -2).
std::vector<GroupedObservation> balanced(int n_groups, int n_views, double known, Random& random) {
  std::vector<GroupedObservation> all;
  for (int g = 0; g < n_groups; ++g) {
    const Eigen::Vector2d middle = Eigen::Vector2d(5, -2) + draw(random, 2, 2);
    for (int v = 0; v < n_views; ++v) {
      all.push_back(observation(g, middle + draw(random, 1, 1), known));
    }
  }
  return all;
}

/// The mean squares of an analysis of variance along one axis.
struct MeanSquares {
  double mean = 0;
  double between = 0;
  double within = 0;
};

MeanSquares analyse(const std::vector<GroupedObservation>& all,
                    int n_groups,
                    int n_views,
                    int axis) {
  std::vector<double> means(static_cast<std::size_t>(n_groups));
  MeanSquares squares;
  for (const GroupedObservation& one : all) {
    means[static_cast<std::size_t>(one.group)] += one.value_mm[axis] / n_views;
    squares.mean += one.value_mm[axis] / (n_groups * n_views);
  }
  for (const double mean : means) {
    squares.between += n_views * std::pow(mean - squares.mean, 2) / (n_groups - 1);
  }
  for (const GroupedObservation& one : all) {
    squares.within += std::pow(one.value_mm[axis] - means[static_cast<std::size_t>(one.group)], 2) /
                      (n_groups * (n_views - 1));
  }
  return squares;
}

TEST(VarianceComponents, AreThoseOfAnAnalysisOfVarianceForBalancedData) {
  // Searle, Casella and McCulloch 1992, 4.8: REML and ANOVA agree where neither is negative.
  constexpr int kGroups = 7;
  constexpr int kViews = 3;
  constexpr double kKnown = 0.2;
  Random random(3);
  const auto all = balanced(kGroups, kViews, kKnown, random);
  const auto fit = fit_mixed(all, {.per_axis = true});
  ASSERT_TRUE(fit);
  for (int axis = 0; axis < 2; ++axis) {
    const MeanSquares squares = analyse(all, kGroups, kViews, axis);
    EXPECT_NEAR(fit->fixed[axis], squares.mean, kTight);
    EXPECT_NEAR(fit->within.value_mm2[axis], squares.within - kKnown, kTight);
    EXPECT_NEAR(fit->between.value_mm2[axis], (squares.between - squares.within) / kViews, kTight);
    EXPECT_NEAR(fit->cov(axis, axis), squares.between / (kGroups * kViews), kTight);
    EXPECT_NEAR(fit->degrees_of_freedom[axis], kGroups - 1, 1e-5);
    // Of a mean square with n degrees of freedom: its square times sqrt(2 / n).
    const double n_within = kGroups * (kViews - 1);
    EXPECT_NEAR(fit->within.error_mm2[axis], squares.within * std::sqrt(2 / n_within), 1e-5);
  }
}

TEST(VarianceComponents, OfBothAxesArePooled) {
  constexpr int kGroups = 7;
  constexpr int kViews = 3;
  Random random(3);
  const auto all = balanced(kGroups, kViews, 0.2, random);
  const auto fit = fit_mixed(all, {});
  ASSERT_TRUE(fit);
  const MeanSquares x = analyse(all, kGroups, kViews, 0);
  const MeanSquares y = analyse(all, kGroups, kViews, 1);
  EXPECT_NEAR(fit->within.value_mm2[0], 0.5 * (x.within + y.within) - 0.2, kTight);
  EXPECT_NEAR(fit->cov(0, 0), 0.5 * (x.between + y.between) / (kGroups * kViews), kTight);
  EXPECT_NEAR(fit->degrees_of_freedom[1], 2 * (kGroups - 1), 1e-5);
  // F(., nu) has the mean nu / (nu - 2).
  EXPECT_THAT(*fit->honest_cov(2), test::IsNearMatrix((fit->cov * 12 / 10).eval(), 1e-6));
}

TEST(VarianceComponents, AreZeroWhereGroupsScatterLessThanTheirMembers) {
  // Both groups have the mean of all: nothing is left between them.
  std::vector<GroupedObservation> all;
  for (int g = 0; g < 4; ++g) {
    for (const double side : {-1.0, 1.0}) {
      all.push_back(observation(g, {10 + side, 20 - side}, 0.01));
    }
  }
  const auto fit = fit_mixed(all, {});
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->between.value_mm2[0], 0);
  EXPECT_GT(fit->between.error_mm2[0], 0);
  // Then all 14 degrees of freedom tell of the within variance: 8 x 2 / 14.
  EXPECT_NEAR(fit->within.value_mm2[0], 16.0 / 14 - 0.01, kTight);
}

TEST(VarianceComponents, AreNotNeededWhereTheKnownNoiseExplainsAll) {
  Random random(4);
  std::vector<GroupedObservation> all;
  for (int g = 0; g < 5; ++g) all.push_back(observation(g, draw(random, 0.1, 0.1), 1));
  const auto fit = fit_mixed(all, {.has_within = false});
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->between.value_mm2[0], 0);
  EXPECT_NEAR(fit->cov(0, 0), 1.0 / 5, kTight);
  EXPECT_TRUE(std::isinf(fit->degrees_of_freedom[0]));
  EXPECT_THAT(*fit->honest_cov(2), test::IsNearMatrix(fit->cov, 0));
}

/// Views of unequal number and noise, with a third column.
std::vector<GroupedObservation> unbalanced() {
  Random random(9);
  std::vector<GroupedObservation> all;
  for (int g = 0; g < 6; ++g) {
    const Eigen::Vector2d middle = draw(random, 1.5, 1.5);
    for (int v = 0; v <= g % 3; ++v) {
      GroupedObservation one = observation(g, middle + draw(random, 1, 1), 0.1 + 0.05 * v);
      one.cov_mm2(0, 1) = one.cov_mm2(1, 0) = 0.03;
      one.design = Eigen::MatrixXd::Zero(2, 3);
      one.design.leftCols<2>() = Eigen::Matrix2d::Identity();
      one.design(0, 2) = random.normal();
      all.push_back(one);
    }
  }
  return all;
}

TEST(VarianceComponents, AreWhereTheLikelihoodIsHighest) {
  const auto all = unbalanced();
  const auto best = fit_mixed(all, {});
  ASSERT_TRUE(best);
  ASSERT_GT(best->between.value_mm2[0], 0);
  ASSERT_GT(best->within.value_mm2[0], 0);
  const auto at = [&](double between_factor, double within_factor) {
    const auto fit = fit_fixed(all,
                               between_factor * best->between.value_mm2[0],
                               within_factor * best->within.value_mm2[0]);
    return fit ? fit->log_likelihood : std::numeric_limits<double>::quiet_NaN();
  };
  const double top = at(1, 1);
  for (const double factor : {0.5, 0.9, 0.99, 1.01, 1.1, 2.0}) {
    EXPECT_LT(at(factor, 1), top) << factor;
    EXPECT_LT(at(1, factor), top) << factor;
    EXPECT_LT(at(factor, 1 / factor), top) << factor;
  }
}

TEST(VarianceComponents, LikelihoodHasTheSlopeItSays) {
  std::vector<Block> blocks(2);
  Random random(5);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const auto n = static_cast<Eigen::Index>(2 * (i + 3));
    blocks[i].design = Eigen::MatrixXd::NullaryExpr(n, 3, [&] { return random.normal(); });
    blocks[i].value = Eigen::VectorXd::NullaryExpr(n, [&] { return random.normal(); });
    blocks[i].known = 0.3 * Eigen::MatrixXd::Identity(n, n);
  }
  const RestrictedLikelihood likelihood(blocks, {{true, 0}, {true, 1}, {false, -1}});
  const Eigen::Vector3d theta(0.4, 0.2, 0.7);
  auto state = likelihood.at(theta);
  ASSERT_TRUE(state);
  likelihood.differentiate(*state);
  constexpr double kStep = 1e-5;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(k);
    const auto above = likelihood.at(theta + step);
    const auto below = likelihood.at(theta - step);
    ASSERT_TRUE(above && below);
    EXPECT_NEAR(
        state->score[k], (above->log_likelihood - below->log_likelihood) / (2 * kStep), 1e-7);
    const Eigen::MatrixXd slope = (above->cov - below->cov) / (2 * kStep);
    EXPECT_THAT(state->slope[static_cast<std::size_t>(k)], test::IsNearMatrix(slope, 1e-7));
  }
}

TEST(VarianceComponents, GainIsTheDerivativeAtFixedVariances) {
  auto all = unbalanced();
  const auto fit = fit_fixed(all, 2, 1);
  ASSERT_TRUE(fit);
  for (std::size_t i = 0; i < all.size(); ++i) {
    auto moved = all;
    moved[i].value_mm.y() += 1;
    const auto other = fit_fixed(moved, 2, 1);
    ASSERT_TRUE(other);
    const Eigen::VectorXd change = other->fixed - fit->fixed;
    EXPECT_THAT(fit->gain.col(static_cast<Eigen::Index>(2 * i + 1)).eval(),
                test::IsNearMatrix(change, 1e-12));
  }
}

TEST(VarianceComponents, OfAnotherGroupAddTheErrorOfTheFit) {
  Random random(3);
  const auto all = balanced(7, 3, 0.2, random);
  const auto fit = fit_fixed(all, 4, 1);
  ASSERT_TRUE(fit);
  const std::vector<GroupedObservation> other = {observation(0, {8, -2}, 0.2),
                                                 observation(0, {10, -2}, 0.2)};
  const GroupDeviation deviation = deviation_of_other(*fit, other);
  EXPECT_NEAR(deviation.mean_mm.x(), 9 - fit->fixed[0], kTight);
  EXPECT_NEAR(deviation.cov_mm2(0, 0), 4 + 1.2 / 2 + (4 + 1.2 / 3) / 7, kTight);
}

TEST(VarianceComponents, RefuseWhatSaysNothing) {
  Random random(3);
  const auto sound = balanced(4, 2, 0.2, random);
  const double nan = std::nan("");
  EXPECT_FALSE(fit_mixed({}, {}));
  EXPECT_FALSE(fit_mixed(std::span(sound).first(1), {}));
  EXPECT_FALSE(fit_fixed(sound, -1, 1));
  EXPECT_FALSE(fit_fixed(sound, nan, 1));
  auto bad = sound;
  bad[1].value_mm.x() = nan;
  EXPECT_FALSE(fit_mixed(bad, {}));
  bad = sound;
  bad[1].cov_mm2 = Eigen::Matrix2d::Zero();
  EXPECT_FALSE(fit_mixed(bad, {}));
  bad = sound;
  bad[1].cov_mm2(0, 1) = 0.1;
  EXPECT_FALSE(fit_mixed(bad, {}));
  bad = sound;
  bad.back().group = 1000;
  EXPECT_FALSE(fit_mixed(bad, {}));
  bad = sound;
  for (GroupedObservation& one : bad) one.design.col(1).setZero();
  EXPECT_FALSE(fit_mixed(bad, {}));
}

}  // namespace
}  // namespace panelcal::internal
