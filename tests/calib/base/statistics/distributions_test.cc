// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/distributions.h"

#include <cmath>
#include <limits>

#include "calib/base/statistics/chi_square.h"
#include "calib/base/statistics/quadrature.h"
#include "calib/base/statistics/random.h"
#include "calib/correction/breaking_probability.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

TEST(DriftDistributions, InvertTheNormalTail) {
  for (const double z : {-30.0, -5.0, -1.0, 0.0, 0.3, 2.0, 6.0, 30.0}) {
    if (z >= -5) {
      EXPECT_NEAR(normal_of_exceedance(normal_exceedance(z)), z, 1e-9) << z;
    }
    EXPECT_NEAR(normal_score(normal_exceedance(-z), normal_exceedance(z)), z, 1e-12) << z;
  }
  EXPECT_EQ(normal_of_exceedance(0), 37);
  EXPECT_NEAR(normal_of_exceedance(0.025), 1.959963984540054, 1e-12);  // any table
}

// Abramowitz and Stegun 1964, table 26.8.
TEST(DriftDistributions, InvertChiSquareAsTabulated) {
  EXPECT_NEAR(chi_square_of_exceedance(0.05, 1), 3.84146, 1e-5);
  EXPECT_NEAR(chi_square_of_exceedance(0.975, 4), 0.484419, 1e-6);
  EXPECT_NEAR(chi_square_of_exceedance(0.025, 10), 20.4831, 1e-4);
  EXPECT_NEAR(chi_square_of_exceedance(0.995, 100), 67.3276, 1e-4);
  for (const int n : {1, 2, 7, 60, 1000}) {
    for (const double chance : {0.001, 0.3, 0.999}) {
      EXPECT_NEAR(chi_square_exceedance(chi_square_of_exceedance(chance, n), n), chance, 1e-9) << n;
    }
  }
  // Between whole numbers it lies between theirs.
  EXPECT_GT(chi_square_of_exceedance(0.025, 7.5), chi_square_of_exceedance(0.025, 7));
  EXPECT_LT(chi_square_of_exceedance(0.025, 7.5), chi_square_of_exceedance(0.025, 8));
}

// Abramowitz and Stegun 1964, table 26.9.
TEST(DriftDistributions, KnowTheRatioOfVariancesAsTabulated) {
  EXPECT_NEAR(variance_ratio_exceedance(4.46, 2, 8), 0.05, 2e-4);
  EXPECT_NEAR(variance_ratio_exceedance(2.98, 10, 10), 0.05, 2e-4);
  EXPECT_NEAR(variance_ratio_exceedance(5.06, 5, 12), 0.01, 4e-5);
  EXPECT_NEAR(variance_ratio_exceedance(1.0, 7, 7), 0.5, 1e-12);
}

TEST(DriftDistributions, RatioOverManyIsChiSquare) {
  for (const double value : {1.0, 9.0, 30.0}) {
    EXPECT_NEAR(
        variance_ratio_exceedance(value / 9, 9, 1e9), chi_square_exceedance(value, 9), 1e-6);
  }
}

TEST(DriftDistributions, RatioOverInfinitelyManyIsChiSquareToTheLastDigit) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const double value : {1.0, 9.0, 300.0}) {
    EXPECT_EQ(variance_ratio_exceedance(value / 9, 9, kInfinite), chi_square_exceedance(value, 9));
  }
}

TEST(DriftDistributions, TailsOfTheRatioMirrorEachOther) {
  for (const double ratio : {0.01, 0.3, 1.0, 2.5, 40.0}) {
    EXPECT_NEAR(
        variance_ratio_exceedance(ratio, 5, 18) + variance_ratio_exceedance(1 / ratio, 18, 5),
        1,
        1e-12);
  }
}

TEST(DriftDistributions, QuadratureIsExactForPolynomials) {
  const auto rule = internal::gauss_legendre(5, -1, 3);
  double sum = 0;
  for (std::size_t i = 0; i < 5; ++i) sum += rule.weights[i] * std::pow(rule.nodes[i], 9);
  EXPECT_NEAR(sum, (std::pow(3, 10) - 1) / 10, 1e-9);
}

TEST(DriftDistributions, ExceedanceAboutZeroIsTheBreakingProbability) {
  Eigen::Matrix2d cov;
  cov << 4e-6, 1.5e-6, 1.5e-6, 1e-6;
  for (const double radius_mm : {0.0005, 0.002, 0.005, 0.008}) {
    EXPECT_NEAR(exceedance_about(Eigen::Vector2d::Zero(), cov, radius_mm),
                breaking_probability(cov, mm(radius_mm)),
                1e-9)
        << radius_mm;
  }
}

TEST(DriftDistributions, ExceedanceAboutAMeanIsWhatDrawsSay) {
  constexpr int kDraws = 200000;
  Eigen::Matrix2d root;
  root << 2, 0, 1, 0.5;
  const Eigen::Vector2d mean(-1.5, 2);
  Random random(31);
  int n_outside = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double first = random.normal();
    const Eigen::Vector2d e = mean + root * Eigen::Vector2d(first, random.normal());
    n_outside += e.norm() > 4;
  }
  const double chance = exceedance_about(mean, root * root.transpose(), 4);
  EXPECT_NEAR(n_outside / static_cast<double>(kDraws),
              chance,
              4 * std::sqrt(chance * (1 - chance) / kDraws));
}

TEST(DriftDistributions, ExceedanceHasEnds) {
  const Eigen::Matrix2d none = Eigen::Matrix2d::Zero();
  EXPECT_NEAR(exceedance_about(Eigen::Vector2d(0.5, 0.5), none, 1), 0, 1e-12);
  EXPECT_NEAR(exceedance_about(Eigen::Vector2d(1, 0.5), none, 1), 1, 1e-12);
  EXPECT_EQ(exceedance_about(Eigen::Vector2d(std::nan(""), 0), none, 1), 1);
  EXPECT_EQ(exceedance_about(Eigen::Vector2d(0, 0), none, 0), 1);
  const Eigen::VectorXd at = Eigen::VectorXd::Constant(1, 1);
  EXPECT_NEAR(exceedance_about(at, Eigen::MatrixXd::Constant(1, 1, 4), 3),
              normal_exceedance(1) + normal_exceedance(2),
              1e-15);
}

}  // namespace
}  // namespace panelcal
