// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "vision/render/render.h"
#include <gtest/gtest.h>

#include "tests/vision/render/scene_support.h"

namespace panelcal::test {
namespace {

constexpr int kSide = 500;
constexpr double kPixels = double{kSide} * kSide;

Camera sensor() {
  Camera camera = scene_camera();
  camera.width = kSide;
  camera.height = kSide;
  camera.full_scale = 65535;
  return camera;
}

std::vector<double> flat(double level) {
  return std::vector<double>(static_cast<std::size_t>(kPixels), level);
}

struct Spread {
  double mean = 0;
  double sigma = 0;
};

Spread spread_of(const Image& image) {
  Spread spread;
  for (const float v : image.pixels()) spread.mean += static_cast<double>(v) / kPixels;
  for (const float v : image.pixels()) {
    spread.sigma += std::pow(static_cast<double>(v) - spread.mean, 2) / kPixels;
  }
  spread.sigma = std::sqrt(spread.sigma);
  return spread;
}

/// 250,000 normal numbers: seed 11.
TEST(Sensor, NoiseIsNormal) {
  Camera camera = sensor();
  camera.noise = 1000;
  Random random(11);
  const Image image = expose(flat(30000), camera, random);
  const Spread spread = spread_of(image);
  EXPECT_NEAR(spread.mean, 30000, 4 * 1000 / std::sqrt(kPixels));
  EXPECT_NEAR(spread.sigma, 1000, 4 * 1000 / std::sqrt(2 * kPixels));
  // Shares beyond 1, 2, 3 and 4 sigma: middle, edges and tail of the ziggurat.
  for (const double limit : {1.0, 2.0, 3.0, 4.0}) {
    const auto pixels = image.pixels();
    const auto n = std::ranges::count_if(
        pixels, [&](float v) { return std::abs(static_cast<double>(v) - 30000) > 1000 * limit; });
    const double expected = kPixels * std::erfc(limit / std::numbers::sqrt2);
    EXPECT_NEAR(static_cast<double>(n), expected, 4 * std::sqrt(expected) + 1) << limit;
  }
}

TEST(Sensor, NeighbouringPixelsKnowNothingOfEachOther) {
  Camera camera = sensor();
  camera.noise = 1000;
  Random random(12);
  const Image image = expose(flat(30000), camera, random);
  for (const int lag : {1, 2, kSide}) {
    double product = 0;
    const auto pixels = image.pixels();
    const auto n = pixels.size() - static_cast<std::size_t>(lag);
    for (std::size_t i = 0; i < n; ++i) {
      product += (static_cast<double>(pixels[i]) - 30000) *
                 (static_cast<double>(pixels[i + static_cast<std::size_t>(lag)]) - 30000);
    }
    EXPECT_NEAR(product / (1e6 * kPixels), 0, 4 / std::sqrt(kPixels)) << lag;
  }
}

TEST(Sensor, ShotNoiseGrowsWithTheLight) {
  Camera camera = sensor();
  camera.noise = 30;
  camera.shot_noise = 2;
  for (const double level : {1000.0, 20000.0, 50000.0}) {
    Random random(13);
    const double expected = std::sqrt(30 * 30 + 2 * level);
    EXPECT_NEAR(spread_of(expose(flat(level), camera, random)).sigma, expected, 0.01 * expected);
  }
}

TEST(Sensor, HotPixelsAreTheSensorsOwn) {
  Camera camera = sensor();
  camera.hot_pixels = 1e-3;
  Random first(1);
  Random second(2);
  const Image image = expose(flat(100), camera, first);
  EXPECT_EQ(image, expose(flat(100), camera, second));
  const auto pixels = image.pixels();
  const auto n = std::ranges::count_if(pixels, [](float v) { return v > 5000; });
  EXPECT_NEAR(static_cast<double>(n), 250, 2);  // two may share a place
  camera.hot_pixels_at = 2;
  EXPECT_NE(image, expose(flat(100), camera, first));
}

TEST(Sensor, CountsWholeLevelsAndClips) {
  Camera camera = scene_camera();
  camera.width = 4;
  camera.height = 1;
  camera.full_scale = 255;
  Random random(1);
  const Image image = expose(std::vector<double>{-3, 1.4, 1.5, 300}, camera, random);
  EXPECT_EQ(image.at(0, 0), 0);
  EXPECT_EQ(image.at(1, 0), 1);
  EXPECT_EQ(image.at(2, 0), 2);
  EXPECT_EQ(image.at(3, 0), 255);
}

}  // namespace
}  // namespace panelcal::test
