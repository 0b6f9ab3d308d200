// SPDX-License-Identifier: Apache-2.0
#include "vision/render/scene_debris.h"

#include <cmath>
#include <numbers>

#include "vision/render/render.h"
#include <gtest/gtest.h>

#include "tests/vision/render/scene_support.h"

namespace panelcal::test {
namespace {

Feature disc_mark(const Camera& camera) {
  Feature disc;
  disc.center = camera.mapping(position_px(100.3, 89.6));
  disc.size = mm(0.8);
  disc.level = 0.8;
  return disc;
}

/// Part of the disc's rim where a picture of nothing but the debris is bright.
double seen_rim_share(const Debris& debris, const Camera& camera) {
  Scene scene = scene_of(debris.features);
  for (Feature& feature : scene.features) feature.level = 1;
  const auto levels = render_levels(scene, camera);
  constexpr int kPlaces = 2000;
  int n_covered = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPlaces;
    const int x = static_cast<int>(std::lround(100.3 + 40 * std::cos(angle)));
    const int y = static_cast<int>(std::lround(89.6 + 40 * std::sin(angle)));
    n_covered += level_at(levels, camera, x, y) > 0.5 ? 1 : 0;
  }
  return static_cast<double>(n_covered) / kPlaces;
}

TEST(Debris, CoversTheShareAskedFor) {
  const Camera camera = scene_camera(0.3);
  for (const double share : {0.05, 0.1, 0.3, 0.6}) {
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      Random random(seed);
      const Debris debris =
          strew_debris({disc_mark(camera)}, {.rim_share = share, .size = um(80)}, random);
      EXPECT_NEAR(debris.rim_share, share, 2e-3) << seed;
      // Places are looked up in whole pixels: a fraction of one at both ends of each crumb.
      EXPECT_NEAR(seen_rim_share(debris, camera), share, 0.03) << seed;
    }
  }
}

TEST(Debris, TouchesNothingButItsMask) {
  const Camera camera = scene_camera();
  const Feature mark = disc_mark(camera);
  Random random(5);
  const Debris debris = strew_debris({mark}, {.rim_share = 0.2, .scratches = 3}, random);
  Scene scene = scene_of({mark});
  const auto clean = render_levels(scene, camera);
  scene.features.insert(scene.features.end(), debris.features.begin(), debris.features.end());
  const auto dirty = render_levels(scene, camera);
  constexpr double kDirtyShare = 1e-3;
  const std::vector<bool> touched = touched_pixels(debris.features, camera, kDirtyShare);
  int n_touched = 0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    n_touched += touched[i] ? 1 : 0;
    if (touched[i]) continue;
    ASSERT_NEAR(clean[i], dirty[i], kDirtyShare);
  }
  EXPECT_GT(n_touched, 200);
  EXPECT_LT(n_touched, static_cast<int>(clean.size()) / 4);
}

TEST(Debris, IsAFunctionOfTheSeed) {
  const Camera camera = scene_camera();
  const auto picture = [&](std::uint64_t seed) {
    Random random(seed);
    return render_levels(
        scene_of(
            strew_debris({disc_mark(camera)}, {.rim_share = 0.2, .scratches = 2}, random).features),
        camera);
  };
  EXPECT_EQ(picture(1), picture(1));
  EXPECT_NE(picture(1), picture(2));
}

TEST(Debris, NoneMeansNone) {
  const Camera camera = scene_camera();
  Random random(1);
  const Debris debris = strew_debris({disc_mark(camera)}, {}, random);
  EXPECT_TRUE(debris.features.empty());
  EXPECT_EQ(debris.rim_share, 0);
  EXPECT_TRUE(strew_debris({}, {.rim_share = 0.5, .scratches = 2}, random).features.empty());
}

}  // namespace
}  // namespace panelcal::test
