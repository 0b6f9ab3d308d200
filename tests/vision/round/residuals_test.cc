// SPDX-License-Identifier: Apache-2.0
#include "vision/round/residuals.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "vision/round/strangers.h"
#include <gtest/gtest.h>

#include "tests/vision/round/model/rim_value.h"
#include "tests/vision/trial.h"

namespace panelcal::internal {
namespace {

constexpr int kSide = 160;
constexpr double kRadiusPx = 30;
constexpr double kNoise = 4;
const Eigen::Vector2d kCenter(79.3, 80.8);

RimVector truth() {
  RimVector p = RimVector::Zero();
  p[kRadius] = kRadiusPx;
  p[kSigma] = std::sqrt(1 + kPixelVariance);
  p[kLevel] = 80;
  p[kContrast] = 100;
  return p;
}

Image picture(std::uint64_t seed, const std::vector<Feature>& others = {}) {
  Camera camera = test::plain_camera(kSide, kSide);
  camera.noise = kNoise;
  Scene scene;
  scene.background = 80.0 / 255;
  scene.features = {test::disc_at(camera, kCenter.x(), kCenter.y(), kRadiusPx, 180.0 / 255)};
  scene.features.insert(scene.features.end(), others.begin(), others.end());
  Random random(seed);
  return render(scene, camera, random);
}

/// A window about the true rim, with what the true model leaves.
struct Looked {
  explicit Looked(const Image& image)
      : window(image, FitFrame(nullptr, kCenter), truth(), 25, false) {
    window.collect(truth(), 6, 1);
    residuals = residuals_of(window, truth());
    noise = estimate_noise(window, residuals, truth()[kContrast]);
  }
  RimWindow window;
  RimResiduals residuals;
  RimNoiseEstimate noise;
};

TEST(RimResiduals, AreThePictureMinusTheModel) {
  const Image image = picture(1);
  const Looked looked(image);
  int n = 0;
  for (const RimSpan& span : looked.window.spans()) {
    for (int x = span.x0; x < span.x1; ++x) {
      RimPixel pixel;
      const Eigen::Vector2d u(looked.window.x0() + x, looked.window.y0() + span.y);
      pixel.at = (u - kCenter).cast<float>();
      pixel.jacobian.setIdentity();
      pixel.plane = looked.window.plane_at(x, span.y).cast<float>();
      const double model = rim_value(pixel, truth(), false, nullptr).level;
      const std::size_t i = looked.window.index(x, span.y);
      constexpr double kFloat = 1e-3;
      ASSERT_NEAR(looked.residuals.values[i], looked.window.value(x, span.y) - model, kFloat);
      ASSERT_NE(looked.residuals.kinds[i], RimResiduals::kNowhere);
      ++n;
    }
  }
  EXPECT_GT(n, 5000);
}

TEST(RimResiduals, WhiteNoiseIsMeasuredAndNotTakenForTexture) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Image image = picture(seed);
    Looked looked(image);
    ASSERT_FALSE(looked.noise.is_textured) << seed;
    // Over 1000 pixels a zone: one standard deviation is below 2.2 %.
    EXPECT_NEAR(looked.noise.total[RimZone::Outside], kNoise, 0.1 * kNoise) << seed;
    EXPECT_NEAR(looked.noise.total[RimZone::Target], kNoise, 0.1 * kNoise) << seed;
    EXPECT_NEAR(looked.noise.rim_sigma, kNoise, 0.1 * kNoise) << seed;
    EXPECT_NEAR(looked.noise.rim_ratio, 1, 0.2) << seed;
    EXPECT_FALSE(has_strangers(looked.window, looked.residuals, looked.noise, truth())) << seed;
    EXPECT_EQ(visible_share(looked.window, truth()), 1) << seed;
  }
}

TEST(RimResiduals, TextureIsSeenAndItsWhitePartToo) {
  Image image = picture(2);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      if ((Eigen::Vector2d(x, y) - kCenter).norm() < kRadiusPx) continue;
      image.at(x, y) += static_cast<float>(8 * std::sin(0.35 * x) * std::cos(0.3 * y));
    }
  }
  const Looked looked(image);
  EXPECT_TRUE(looked.noise.is_textured);
  EXPECT_NEAR(looked.noise.white, kNoise, 0.15 * kNoise);
  EXPECT_NEAR(looked.noise.total[RimZone::Outside], std::sqrt(16 + 16.0), 0.6);
}

TEST(RimResiduals, TextureOfTheTargetAloneIsSeenToo) {
  Image image = picture(4);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      if ((Eigen::Vector2d(x, y) - kCenter).norm() > kRadiusPx - 3) continue;
      image.at(x, y) += static_cast<float>(5 * std::sin(0.7 * x) * std::cos(0.6 * y));
    }
  }
  EXPECT_TRUE(Looked(image).noise.is_textured);
}

TEST(RimResiduals, AChipOnTheRimIsStrangeAndHidesIt) {
  const Camera camera = test::plain_camera(kSide, kSide);
  const Eigen::Vector2d chip = kCenter + Eigen::Vector2d(kRadiusPx, 0);
  const Image image = picture(3, {test::disc_at(camera, chip.x(), chip.y(), 8, 20.0 / 255)});
  const Looked looked(image);
  EXPECT_TRUE(has_strangers(looked.window, looked.residuals, looked.noise, truth()));
  // The chip takes 16 px of 188.
  EXPECT_LT(visible_share(looked.window, truth()), 1 - 16.0 / 188 + 0.03);
  EXPECT_GT(visible_share(looked.window, truth()), 0.7);
}

}  // namespace
}  // namespace panelcal::internal
