// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/rim_blur.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

constexpr Eigen::Index kBlurSectors = 120;
constexpr double kEdgeSigma_px = 1.2;

/// side cos phi + axis cos 2 (phi - turn), and noise.
Eigen::VectorXd blurs_of(
    double side, double axis, double turn_rad, double noise_px, std::uint64_t seed = 1) {
  Random random(seed);
  Eigen::VectorXd blurs(kBlurSectors);
  for (Eigen::Index i = 0; i < kBlurSectors; ++i) {
    const double phi = 2 * std::numbers::pi * static_cast<double>(i) / kBlurSectors;
    blurs[i] =
        side * std::cos(phi) + axis * std::cos(2 * (phi - turn_rad)) + noise_px * random.normal();
  }
  return blurs;
}

std::vector<char> all_sectors() {
  return std::vector<char>(static_cast<std::size_t>(kBlurSectors), 1);
}

TEST(RimBlur, NoiseHidesNothing) {
  const Eigen::Matrix2d cov = hidden_by_blur(blurs_of(0, 0, 0, 0.2), all_sectors(), kEdgeSigma_px);
  EXPECT_LT(cov.trace(), 0.002);  // (0.2 px)^2 4 / 120 sectors: of one wave by chance
}

TEST(RimBlur, AOneSidedBlurCountsAlongItsSide) {
  const Eigen::Matrix2d cov =
      hidden_by_blur(blurs_of(0.3, 0, 0, 0.02), all_sectors(), kEdgeSigma_px);
  EXPECT_NEAR(cov(0, 0), 0.09, 0.005);
  EXPECT_LT(cov(1, 1), 0.001);
}

TEST(RimBlur, ColoursThatAreShiftedCountAlongTheirShift) {
  constexpr double kTurn = std::numbers::pi / 6;
  const Eigen::Matrix2d cov =
      hidden_by_blur(blurs_of(0, 0.15, kTurn, 0.005), all_sectors(), kEdgeSigma_px);
  const Eigen::Vector2d along(std::cos(kTurn), std::sin(kTurn));
  const Eigen::Vector2d across(-along.y(), along.x());
  // 4 x 1.2 x 0.15 px^2 of spread, of which 0.15 are any lens's.
  EXPECT_NEAR(along.dot(cov * along), 0.35 * 0.35 * (0.72 - 0.15), 0.003);
  EXPECT_LT(across.dot(cov * across), 0.001);
}

TEST(RimBlur, VibrationCountsOnlyAsMuchAsALensMakes) {
  const Eigen::Matrix2d cov =
      hidden_by_blur(blurs_of(0, 0.8, 0, 0.005), all_sectors(), kEdgeSigma_px);
  EXPECT_NEAR(cov(0, 0), 0.35 * 0.35 * (1 - 0.15), 0.001);
  EXPECT_LT(cov(1, 1), 0.001);
}

/// The values less their wave of one period.
Eigen::VectorXd without_side(Eigen::VectorXd values) {
  const auto n = static_cast<double>(values.size());
  Eigen::VectorXd cosine(values.size());
  Eigen::VectorXd sine(values.size());
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    cosine[i] = std::cos(2 * std::numbers::pi * static_cast<double>(i) / n);
    sine[i] = std::sin(2 * std::numbers::pi * static_cast<double>(i) / n);
  }
  values -= (2 / n * values.dot(cosine) * cosine + 2 / n * values.dot(sine) * sine).eval();
  return values;
}

/// A wave's power over that of six others is F distributed, of 2 and 12 degrees of freedom: beyond
/// 3 in 1.5^-6 = 8.8 % of the draws, and then its spread is about 0.9 px^2 here.
TEST(RimBlur, NoiseSeldomLooksLikeColours) {
  constexpr int kDraws = 400;
  int n_hidden = 0;
  for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
    const Eigen::VectorXd blurs = without_side(blurs_of(0, 0, 0, 0.6, seed));
    n_hidden += hidden_by_blur(blurs, all_sectors(), kEdgeSigma_px).trace() > 1e-6 ? 1 : 0;
  }
  constexpr double kBeyond = 0.0878;
  const double four_sigmas = 4 * std::sqrt(kBeyond * (1 - kBeyond) * kDraws);
  EXPECT_NEAR(n_hidden, kBeyond * kDraws, four_sigmas);
}

TEST(RimBlur, ASoundLensAstigmatismHidesNothing) {
  const Eigen::Matrix2d cov =
      hidden_by_blur(blurs_of(0, 0.03, 0, 0.005), all_sectors(), kEdgeSigma_px);
  EXPECT_LT(cov.trace(), 1e-4);
}

TEST(RimBlur, SectorsThatAreLeftOutDoNotCount) {
  Eigen::VectorXd blurs = blurs_of(0, 0, 0, 0.02);
  std::vector<char> use = all_sectors();
  for (Eigen::Index i = 20; i < 40; ++i) {
    blurs[i] = 5;
    use[static_cast<std::size_t>(i)] = 0;
  }
  EXPECT_LT(hidden_by_blur(blurs, use, kEdgeSigma_px).trace(), 1e-3);
}

}  // namespace
}  // namespace panelcal::internal
