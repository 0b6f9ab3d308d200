// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <numbers>

#include "calib/base/statistics/random.h"
#include "vision/locate/locate.h"
#include <gtest/gtest.h>

#include "tests/vision/trial.h"

namespace panelcal::internal {
namespace {

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

TEST(RimShape, HexagonsInStrongNoiseAreNoDiscsAndDiscsAre) {
  constexpr int kPictures = 25;
  constexpr double kPadRadius_px = 20;
  Target target;
  target.size_px = px(2 * kPadRadius_px);
  int n_discs = 0;
  for (int i = 0; i < kPictures; ++i) {
    Random random = Random(15).fork(static_cast<std::uint64_t>(i));
    Camera camera = test::plain_camera(200, 200);
    camera.blur_px = 2;
    camera.noise = 10;
    Scene scene;
    scene.background = 0.5;
    // As large as the disc all in all, so that only the shape tells.
    scene.features = hexagon_at(camera, 1.1 * kPadRadius_px, random.uniform(0, 1));
    const Detection hexagon = locate(render(scene, camera, random), target);
    EXPECT_NE(hexagon.status, DetectionStatus::Found) << i;
    scene.features = {test::disc_at(camera, 100, 100, kPadRadius_px, 0.66)};
    n_discs += locate(render(scene, camera, random), target).status == DetectionStatus::Found;
  }
  EXPECT_EQ(n_discs, kPictures);
}

}  // namespace
}  // namespace panelcal::internal
