// SPDX-License-Identifier: Apache-2.0
#include "vision/texture/lines.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

constexpr int kSide = 128;  // as the window of a disc of 40 px radius
constexpr double kTurn = 2 * std::numbers::pi;

struct PlantedWave {
  Eigen::Vector2d cycles_per_px;
  double amplitude = 0;
  double phase = 0;
};

/// Waves and white noise around a disc, 0 on it and in the window's corners.
std::vector<float> ground(const std::vector<PlantedWave>& waves, double noise, Random& random) {
  std::vector<float> values;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      double v = noise * random.normal();
      for (const PlantedWave& w : waves) {
        v += w.amplitude * std::cos(kTurn * w.cycles_per_px.dot(Eigen::Vector2d(x, y)) + w.phase);
      }
      const double r = std::hypot(x - 63.5, y - 63.5);
      values.push_back(r > 44 && r < 64 ? static_cast<float>(v) : 0.0F);
    }
  }
  return values;
}

FlatResiduals residuals_of(const std::vector<float>& values) {
  double n = 0;
  for (const float v : values) n += v != 0;
  return {values, kSide, n};
}

/// Cycles per px between a line and a wave; a wave and its reverse are one.
double distance(const TextureLine& line, const PlantedWave& wave) {
  const Eigen::Vector2d f = line.wave_per_px / kTurn;
  return std::min((f - wave.cycles_per_px).norm(), (f + wave.cycles_per_px).norm());
}

double rms(const std::vector<float>& values, double n) {
  double sum = 0;
  for (const float v : values) sum += static_cast<double>(v * v);
  return std::sqrt(sum / n);
}

TEST(TextureLines, FindsTwoPlantedWaves) {
  constexpr double kMaxError = 1e-3;  // cycles per px: over the window an eighth of a cycle
  constexpr int kDraws = 100;
  for (int i = 0; i < kDraws; ++i) {
    Random random = Random(20260101).fork(static_cast<std::uint64_t>(i));
    const double turn = random.uniform(-0.3, 0.3);
    const double f = random.uniform(1 / 40.0, 1 / 18.0);
    const PlantedWave strong{
        f * Eigen::Vector2d(std::cos(turn), std::sin(turn)), 8, random.uniform(0, kTurn)};
    const PlantedWave weak{
        f * Eigen::Vector2d(-std::sin(turn), std::cos(turn)), 5, random.uniform(0, kTurn)};
    const std::vector<float> values = ground({strong, weak}, 3, random);
    std::vector<float> left;
    const FlatResiduals residuals = residuals_of(values);
    const auto lines = texture_lines(residuals, left);
    ASSERT_GE(lines.size(), 2U) << "draw " << i;
    // A weak wave may take up what the error of one beside it leaves.
    for (std::size_t k = 2; k < lines.size(); ++k) EXPECT_LT(lines[k].amplitude, 2) << i;
    EXPECT_LT(distance(lines[0], strong), kMaxError) << "draw " << i;
    EXPECT_LT(distance(lines[1], weak), kMaxError) << "draw " << i;
    EXPECT_NEAR(lines[0].amplitude, 8, 0.8) << "draw " << i;
    EXPECT_NEAR(lines[1].amplitude, 5, 0.8) << "draw " << i;
    // Noise remains, with a little of the waves.
    EXPECT_NEAR(rms(left, residuals.n), 3, 0.4) << "draw " << i;
  }
}

TEST(TextureLines, FindsNoneInWhiteNoise) {
  constexpr int kDraws = 100;
  for (int i = 0; i < kDraws; ++i) {
    Random random = Random(20260102).fork(static_cast<std::uint64_t>(i));
    const std::vector<float> values = ground({}, 5, random);
    std::vector<float> left;
    EXPECT_TRUE(texture_lines(residuals_of(values), left).empty()) << "draw " << i;
    EXPECT_EQ(left, values);
  }
}

TEST(TextureLines, LeavesPlacesWithoutPictureAlone) {
  Random random(3);
  const std::vector<float> values = ground({{{0.04, 0.01}, 10, 1}}, 2, random);
  std::vector<float> left;
  ASSERT_GE(texture_lines(residuals_of(values), left).size(), 1U);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] != 0) continue;
    ASSERT_EQ(left[i], 0.0F);
  }
}

TEST(TextureLines, TinyAndEmptyWindowsHaveNone) {
  for (const int side : {1, 3, 5}) {
    const std::vector<float> zeros(static_cast<std::size_t>(side * side), 0.0F);
    std::vector<float> left;
    EXPECT_TRUE(texture_lines({zeros, side, 0}, left).empty());
    EXPECT_EQ(left, zeros);
  }
}

}  // namespace
}  // namespace panelcal::internal
