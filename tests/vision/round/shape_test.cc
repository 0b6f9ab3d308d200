// SPDX-License-Identifier: Apache-2.0
#include "vision/round/shape.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>

#include "calib/base/random.h"
#include "vision/locate/locate.h"
#include <gtest/gtest.h>

#include "tests/vision/trial.h"

namespace panelcal::internal {
namespace {

constexpr std::size_t kSectors = 48;

/// A rim with a wave around it, in white noise of sigma 1.
std::vector<RimDeviation> noisy_rim(Random& random, int n_lobes = 0, double amplitude = 0) {
  std::vector<RimDeviation> deviations(kSectors);
  const double phase = random.uniform(0, 2 * std::numbers::pi);
  for (std::size_t i = 0; i < kSectors; ++i) {
    const double phi = 2 * std::numbers::pi * static_cast<double>(i) / kSectors;
    deviations[i] = {random.normal() + amplitude * std::cos(n_lobes * phi + phase), 1};
  }
  return deviations;
}

TEST(RimLobes, NoiseAloneIsAsRareAsStated) {
  Random random(11);
  constexpr int kDraws = 4000;
  int n_above = 0;
  for (int i = 0; i < kDraws; ++i) n_above += rim_lobes(noisy_rim(random)).significance > 6;
  // An F distribution of 2 and 41 degrees of freedom, six times: 125 +- 11.
  const double expected = 6 * std::pow(1 + 6 / 20.5, -20.5) * kDraws;
  EXPECT_NEAR(n_above, expected, 4 * std::sqrt(expected));
}

TEST(RimLobes, CountsTheSidesOfAPolygon) {
  Random random(12);
  for (int n = 3; n <= 8; ++n) {
    // Amplitudes of 48 white numbers have a sigma of 0.2 each way.
    const RimLobes lobes = rim_lobes(noisy_rim(random, n, 3));
    EXPECT_EQ(lobes.n, n);
    EXPECT_NEAR(lobes.amplitude_px, 3, 0.8);
    EXPECT_GT(lobes.significance, 30);
  }
}

TEST(RimLobes, DebrisIsNoWave) {
  Random random(13);
  for (int i = 0; i < 400; ++i) {
    auto rim = noisy_rim(random);
    const auto first = static_cast<std::size_t>(random.uniform(0, 40));
    for (std::size_t k = first; k < first + 5; ++k) rim[k].px += 20;
    const RimLobes lobes = rim_lobes(rim);
    EXPECT_LT(lobes.amplitude_px, 2);
    EXPECT_LT(lobes.significance, 30);
  }
}

TEST(RimLobes, OfHalfARimNothingIsSaid) {
  Random random(14);
  auto rim = noisy_rim(random, 6, 5);
  for (std::size_t k = 0; k < kSectors / 2; ++k) rim[k] = {};
  EXPECT_EQ(rim_lobes(rim).n, 0);
  EXPECT_EQ(rim_lobes({}).n, 0);
}

/// A regular hexagon is the union of three rectangles.
std::vector<Feature> hexagon_at(const Camera& camera, double corner_px, double turn_rad) {
  std::vector<Feature> features;
  for (int i = 0; i < 3; ++i) {
    Feature f = test::disc_at(camera, 100, 100, 0.5 * corner_px, 0.66);
    f.shape = Feature::Shape::Rectangle;
    f.inner_size = std::numbers::sqrt3 * f.size;
    f.angle = rad(turn_rad + i * std::numbers::pi / 3);
    features.push_back(f);
  }
  return features;
}

TEST(RimLobes, HexagonsInStrongNoiseAreNoDiscsAndDiscsAre) {
  constexpr int kPictures = 25;
  constexpr double kHexagonRadiusPx = 20;
  Target target;
  target.size_px = px(2 * kHexagonRadiusPx);
  int n_discs = 0;
  for (int i = 0; i < kPictures; ++i) {
    Random random = Random(15).fork(static_cast<std::uint64_t>(i));
    Camera camera = test::plain_camera(200, 200);
    camera.blur_px = 2;
    camera.noise = 10;
    Scene scene;
    scene.background = 0.5;
    // As large as the disc all in all, so that only the shape tells.
    scene.features = hexagon_at(camera, 1.1 * kHexagonRadiusPx, random.uniform(0, 1));
    const Detection hexagon = locate(render(scene, camera, random), target);
    EXPECT_NE(hexagon.status, DetectionStatus::Found) << i;
    scene.features = {test::disc_at(camera, 100, 100, kHexagonRadiusPx, 0.66)};
    n_discs += locate(render(scene, camera, random), target).status == DetectionStatus::Found;
  }
  EXPECT_EQ(n_discs, kPictures);
}

}  // namespace
}  // namespace panelcal::internal
