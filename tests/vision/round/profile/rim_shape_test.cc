// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/rim_shape.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

constexpr Eigen::Index kShapeSectors = 120;
constexpr double kShapeNoise_px = 0.1;

Eigen::VectorXd wave_px(double amplitude_px, int n_periods) {
  Eigen::VectorXd wave(kShapeSectors);
  for (Eigen::Index i = 0; i < kShapeSectors; ++i) {
    wave[i] = amplitude_px *
              std::cos(2 * std::numbers::pi * n_periods * static_cast<double>(i) / kShapeSectors);
  }
  return wave;
}

Eigen::VectorXd with_noise(Eigen::VectorXd values) {
  Random random(1);
  for (double& v : values) v += kShapeNoise_px * random.normal();
  return values;
}

std::vector<char> every_sector() {
  return std::vector<char>(static_cast<std::size_t>(kShapeSectors), 1);
}

double shape_rms(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

constexpr double kShapeVariance = kShapeNoise_px * kShapeNoise_px;

TEST(RimShape, FollowsAnOvalAndLobes) {
  const Eigen::VectorXd truth = wave_px(0.8, 2) + wave_px(0.4, 5);
  const Eigen::VectorXd shape = rim_shape(with_noise(truth), every_sector(), kShapeVariance);
  EXPECT_LT(shape_rms(shape - truth), kShapeNoise_px);
}

TEST(RimShape, NoiseIsHardlyAShape) {
  const Eigen::VectorXd shape =
      rim_shape(with_noise(Eigen::VectorXd::Zero(kShapeSectors)), every_sector(), kShapeVariance);
  EXPECT_LT(shape_rms(shape), 0.3 * kShapeNoise_px);
}

TEST(RimShape, AShiftIsNoShape) {
  EXPECT_LT(shape_rms(rim_shape(wave_px(0.5, 1), every_sector(), kShapeVariance)), 1e-9);
}

TEST(RimShape, SectorsThatAreLeftOutDoNotCount) {
  Eigen::VectorXd residuals = Eigen::VectorXd::Zero(kShapeSectors);
  std::vector<char> use = every_sector();
  for (Eigen::Index i = 10; i < 30; ++i) {
    residuals[i] = 3;
    use[static_cast<std::size_t>(i)] = 0;
  }
  EXPECT_EQ(shape_rms(rim_shape(residuals, use, kShapeVariance)), 0);
}

}  // namespace
}  // namespace panelcal::internal
