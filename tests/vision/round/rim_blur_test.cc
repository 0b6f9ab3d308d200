// SPDX-License-Identifier: Apache-2.0
#include "vision/round/rim_blur.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

constexpr Eigen::Index kBlurSectors = 120;
constexpr double kEdgeSigma_px = 1.2;

/// side cos phi + axis cos 2 (phi - turn), and noise.
Eigen::VectorXd blurs_of(double side, double axis, double turn_rad, double noise_px) {
  Random random(1);
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
