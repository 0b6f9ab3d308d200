// SPDX-License-Identifier: Apache-2.0
#include "machine/job/facts/fit_numbers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "calib/base/statistics/chi_square.h"
#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

TEST(FitNumbers, KnowsChiSquareTables) {
  // Abramowitz and Stegun, table 26.8, to its six figures.
  EXPECT_NEAR(chi_square_exceedance(3.84146, 1), 0.05, 1e-6);
  EXPECT_NEAR(chi_square_exceedance(5.99146, 2), 0.05, 1e-6);
  EXPECT_NEAR(chi_square_exceedance(11.0705, 5), 0.05, 1e-5);
  EXPECT_NEAR(chi_square_exceedance(124.342, 100), 0.05, 1e-5);
  EXPECT_EQ(chi_square_exceedance(0, 3), 1);
  EXPECT_EQ(chi_square_exceedance(1e6, 3), 0);
}

/// P(chi square of 1 > 3.84) = 0.05, > 6.63: 0.01; of 5 degrees > 0.0: 1 (Abramowitz and Stegun).
TEST(FitNumbers, ClaimNoMoreOfAChiSquareThanItTells) {
  EXPECT_EQ(facts::chi_square_meaning(0, 0), "unchecked");
  EXPECT_EQ(facts::chi_square_meaning(1, 1), "weak");
  EXPECT_EQ(facts::chi_square_meaning(5, 1), "rather_large");
  EXPECT_EQ(facts::chi_square_meaning(7, 1), "too_large_weak");
  EXPECT_EQ(facts::chi_square_meaning(5, 5), "as_expected");
  EXPECT_EQ(facts::chi_square_meaning(50, 5), "too_large");
  EXPECT_EQ(facts::chi_square_meaning(0.01, 5), "too_small");
  EXPECT_EQ(facts::chi_square_meaning(std::nan(""), 5), "too_large");
}

/// Draws many fits of one model and holds the scatter of each number against its sigma.
TEST(FitNumbers, PredictsTheScatterOfEveryNumber) {
  constexpr int kDraws = 1000;
  // Standard deviation of a sample's standard deviation is 1 / sqrt(2 N); four of them.
  const double tolerance = 4 / std::sqrt(2.0 * kDraws);
  Eigen::Matrix2d linear;
  linear << 0.8, -0.5, 0.7, 0.9;  // far from the identity, so that every derivative matters
  const Transform<frame::Base, frame::Nominal> truth(linear, Eigen::Vector2d(10, -20));
  Eigen::Matrix2d cov_mm2;
  cov_mm2 << 4e-6, 1.5e-6, 1.5e-6, 1e-6;
  const Eigen::Matrix2d root =
      (Eigen::Matrix2d() << 2e-3, 0, 0.75e-3, std::sqrt(0.4375e-6)).finished();
  Random random(11);
  std::array<double, 6> sum{}, squares{}, sigma{};
  for (int i = 0; i < kDraws; ++i) {
    std::vector<TargetPair<frame::Base, frame::Nominal>> pairs;
    for (const Eigen::Vector2d& p_mm : {Eigen::Vector2d(5, 5),
                                        Eigen::Vector2d(205, 15),
                                        Eigen::Vector2d(0, 150),
                                        Eigen::Vector2d(180, 190)}) {
      const Eigen::Vector2d noise_mm = root * Eigen::Vector2d(random.normal(), random.normal());
      const auto nominal = position_mm<frame::Nominal>(p_mm);
      pairs.push_back(
          {nominal, {truth(nominal) + displacement_mm<frame::Base>(noise_mm), cov_mm2}});
    }
    auto fit = fit_panel<frame::Base, frame::Nominal>(pairs, PanelModel::Affine).fit;
    ASSERT_TRUE(fit.has_value());
    SeriesResult series;
    series.base = std::make_shared<const BaseFit>(*std::move(fit));
    const facts::FitNumbers n = *facts::fit_numbers(series);
    const std::array<facts::Uncertain, 6> all = {
        n.rotation_rad, n.stretch_x_ppm, n.stretch_y_ppm, n.shear_ppm, n.shift_x_mm, n.shift_y_mm};
    for (std::size_t k = 0; k < all.size(); ++k) {
      sum[k] += all[k].value;
      squares[k] += all[k].value * all[k].value;
      sigma[k] = all[k].sigma;
    }
  }
  for (std::size_t k = 0; k < sum.size(); ++k) {
    const double mean = sum[k] / kDraws;
    const double scatter = std::sqrt(std::max(0.0, squares[k] / kDraws - mean * mean));
    EXPECT_NEAR(scatter / sigma[k], 1, tolerance) << "number " << k;
  }
}

}  // namespace
}  // namespace panelcal
