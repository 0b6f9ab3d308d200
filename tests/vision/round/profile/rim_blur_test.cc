// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/rim_blur.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
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

Eigen::Matrix2d hidden_by(const Eigen::VectorXd& blurs) {
  return hidden_by_blur(blurs, all_sectors(), kEdgeSigma_px);
}

TEST(RimBlur, LittleNoiseHidesNothing) {
  // (0.1 px)^2 4 / 120 sectors of one wave by chance; the spread is below a sound lens's.
  EXPECT_LT(hidden_by(blurs_of(0, 0, 0, 0.1)).trace(), 0.002);
}

TEST(RimBlur, AOneSidedBlurCountsAlongItsSide) {
  const Eigen::Matrix2d cov = hidden_by(blurs_of(0.3, 0, 0, 0.02));
  EXPECT_NEAR(cov(0, 0), 0.09, 0.005);
  EXPECT_LT(cov(1, 1), 0.001);
}

constexpr double kPlain_px2 = 0.1;  // a sound lens's spread

TEST(RimBlur, ColoursThatAreShiftedCountAlongTheirShift) {
  constexpr double kTurn = std::numbers::pi / 6;
  const Eigen::Matrix2d cov = hidden_by(blurs_of(0, 0.15, kTurn, 0.005));
  const Eigen::Vector2d along(std::cos(kTurn), std::sin(kTurn));
  const Eigen::Vector2d across(-along.y(), along.x());
  // A third of the spread, of whose square a sound lens has a part, which has any direction.
  constexpr double kSpread_px2 = 4 * kEdgeSigma_px * 0.15;
  const double of_lens = kPlain_px2 * kPlain_px2 / (kSpread_px2 * kSpread_px2);
  const double hidden_px2 = std::sqrt(1 - of_lens) * kSpread_px2 / 3;
  EXPECT_NEAR(along.dot(cov * along), hidden_px2 * (1 - 0.5 * of_lens), 0.003);
  EXPECT_NEAR(across.dot(cov * across), hidden_px2 * 0.5 * of_lens, 0.001);
}

/// Noise turns the direction: an error along the true one must still be within its covariance.
TEST(RimBlur, ColoursCountBesideTheirDirectionAsFarAsNoiseTurnsIt) {
  constexpr int kDraws = 400;
  constexpr double kSpread_px2 = 4 * kEdgeSigma_px * 0.15;
  constexpr double kOther_px = 0.01;  // what else a covariance has
  double squares = 0;
  for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
    const Eigen::Matrix2d cov = hidden_by(blurs_of(0, 0.15, 0, 0.15, seed)) +
                                kOther_px * kOther_px * Eigen::Matrix2d::Identity();
    squares += kSpread_px2 / 3 * cov.inverse()(0, 0) / kDraws;
  }
  // 11 if no direction but the one that is seen counts: noise turns it by 0.07 rad rms.
  EXPECT_LT(squares, 3);
}

/// Weights (a, b, c) of colours at -1, 0 and 1, even where a + b + c = 1: the square of their mean
/// is a third of their variance, on average.
TEST(RimBlur, ThreeColoursOfUnknownStrengthAreAThirdOfTheirSpreadOff) {
  Random random(20261127);
  double mean2 = 0;
  double variance = 0;
  for (int i = 0; i < 20000; ++i) {
    double low = random.uniform();
    double high = random.uniform();
    if (low > high) std::swap(low, high);
    const double mean = (1 - high) - low;
    mean2 += mean * mean;
    variance += (1 - high) + low - mean * mean;
  }
  const double spread_px2 = std::hypot(0.8, kPlain_px2);
  const Eigen::Matrix2d cov = hidden_by(blurs_of(0, spread_px2 / (4 * kEdgeSigma_px), 0, 0.005));
  EXPECT_NEAR(cov.trace() / 0.8, mean2 / variance, 0.02);
}

TEST(RimBlur, VibrationCountsOnlyAsMuchAsALensMakes) {
  EXPECT_NEAR(hidden_by(blurs_of(0, 0.8, 0, 0.005)).trace(), 1.0 / 3, 0.001);
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

/// The power of a wave of noise is exponential, that of six others tells its mean: what is left of
/// its root is 0.30 of the mean's, with a sound lens's spread taken off too, and 0.89 with nothing.
TEST(RimBlur, ChanceIsTakenOffTheSpreadOfColours) {
  constexpr int kDraws = 1000;
  constexpr double kNoise_px = 0.3;
  const double chance_px2 = 4 * kEdgeSigma_px * kNoise_px * std::sqrt(4.0 / kBlurSectors);
  double hidden_px2 = 0;
  for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
    hidden_px2 += hidden_by(without_side(blurs_of(0, 0, 0, kNoise_px, seed))).trace() / kDraws;
  }
  EXPECT_NEAR(hidden_px2, 0.30 * chance_px2 / 3, 0.06 * chance_px2 / 3);  // four sigmas
}

TEST(RimBlur, ASoundLensAstigmatismHidesNothing) {
  EXPECT_LT(hidden_by(blurs_of(0, 0.02, 0, 0.002)).trace(), 1e-4);
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
