// SPDX-License-Identifier: Apache-2.0
#include "vision/locate/focus.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "vision/render/render.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

constexpr int kFocusTrials = 400;
constexpr double kBest_mm = 1.2345;
constexpr double kDepth_mm = 0.08;

/// A bright disc in a picture of 160 x 160 px, 10 um a pixel.
Image disc(double blur_px, double noise, std::uint64_t seed, double light = 1) {
  CameraMapping::Parameters parameters;
  parameters.axis_px << 79.5, 79.5;
  Scene scene;
  Feature pad;
  pad.size = mm(0.8);
  pad.center = position_mm<frame::Optical>(0.003, -0.002);
  pad.level = 0.8 * light;
  scene.features = {pad};
  scene.background = 0.3 * light;
  Camera camera{.mapping = CameraMapping(parameters)};
  camera.width = 160;
  camera.height = 160;
  camera.blur_px = blur_px;
  camera.noise = noise;
  Random random(seed);
  return render(scene, camera, random);
}

double curve(double z_mm) {
  return 3e-3 / std::hypot(1, (z_mm - kBest_mm) / kDepth_mm);
}

std::vector<FocusSample> samples(
    double low_mm, double high_mm, int n, double noise, Random random) {
  std::vector<FocusSample> out;
  for (int i = 0; i < n; ++i) {
    const double z_mm = low_mm + (high_mm - low_mm) * i / (n - 1);
    out.push_back({mm(z_mm), curve(z_mm) + noise * random.normal()});
  }
  return out;
}

/// The strength of a blurred edge of contrast C and length L: the integral of the squared
/// derivative of an error function is C^2 / (2 sqrt(pi) s), and central differences have twice the
/// slope; the box of the pixel and the difference's reach of two pixels widen the edge by 1/12 and
/// 1/3 of a squared pixel.
TEST(Sharpness, OfADiscIsThatOfItsRim) {
  for (const double blur_px : {2.0, 3.0, 5.0}) {
    const Image image = disc(blur_px, 0, 1);
    // Differences reach over a pixel each side, so that the sums leave out the border.
    double mean = 0;
    for (int y = 1; y < 158; ++y) {
      for (int x = 1; x < 158; ++x) mean += static_cast<double>(image.at(x, y)) / (157.0 * 157.0);
    }
    const double contrast = 0.5 * 255;
    const double length_px = std::numbers::pi * 80;
    const double s_px = std::sqrt(blur_px * blur_px + 1.0 / 12 + 1.0 / 3);
    const double expected = 4 * contrast * contrast * length_px /
                            (2 * std::sqrt(std::numbers::pi) * s_px) /
                            (157.0 * 157.0 * mean * mean);
    EXPECT_NEAR(sharpness(image) / expected, 1, 0.03) << blur_px;
  }
}

TEST(Sharpness, NoiseAndLightDoNotChangeIt) {
  const double clean = sharpness(disc(3, 0, 1));
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) sum += sharpness(disc(3, 10, seed));
  // Squared gradients of noise alone would add (10 grey levels)^2 * 4: as much as the rim has.
  EXPECT_NEAR(sum / 20 / clean, 1, 0.05);
  EXPECT_NEAR(sharpness(disc(3, 0, 1, 0.5)) / clean, 1, 0.02);
}

TEST(Sharpness, OfNothingIsZero) {
  EXPECT_EQ(sharpness(Image()), 0);
  EXPECT_EQ(sharpness(Image(3, 3, 255, 9)), 0);
  EXPECT_EQ(sharpness(Image(40, 30, 255, 0)), 0);
  EXPECT_EQ(sharpness(Image(40, 30, 255, 100)), 0);
}

TEST(FocusPeak, IsExactWithoutNoise) {
  std::string reason;
  const auto peak = fit_focus_peak(samples(1.15, 1.3, 9, 0, Random(1)), &reason);
  ASSERT_TRUE(peak) << reason;
  EXPECT_NEAR(peak->z.in_mm(), kBest_mm, 1e-9);
  EXPECT_NEAR(peak->half_depth.in_mm(), kDepth_mm, 1e-9);
}

TEST(FocusPeak, SigmaIsTheRealOne) {
  constexpr double kNoise = 3e-5;  // 1 % of the peak
  double sum = 0;
  double sum_of_squares = 0;
  for (int i = 0; i < kFocusTrials; ++i) {
    const auto peak = fit_focus_peak(
        samples(1.1, 1.4, 15, kNoise, Random(7).fork(static_cast<unsigned>(i))), nullptr);
    ASSERT_TRUE(peak) << i;
    const double error = (peak->z.in_mm() - kBest_mm) / peak->sigma.in_mm();
    sum += error;
    sum_of_squares += error * error;
  }
  EXPECT_LT(std::abs(sum / kFocusTrials), 4 / std::sqrt(kFocusTrials));
  // Errors over sigmas of some ten residuals follow Student's t; its variance is 1.2 to 1.3.
  EXPECT_NEAR(sum_of_squares / kFocusTrials, 1.25, 0.4);
}

TEST(FocusPeak, SaysWhyThereIsNone) {
  std::string reason;
  EXPECT_FALSE(fit_focus_peak({}, &reason));
  EXPECT_EQ(reason, "0 heights are too few for a curve");
  EXPECT_FALSE(fit_focus_peak(samples(-5, 5, 9, 0, Random(1)), &reason));
  EXPECT_EQ(reason, "only 1 of 9 heights is near the sharpest, too few for a curve");
  EXPECT_FALSE(fit_focus_peak(samples(1.1, 1.2, 9, 0, Random(1)), &reason));
  EXPECT_EQ(reason, "the pictures get sharper towards z = 1.2000 mm, the end of the range");
  std::vector<FocusSample> flat;
  Random random(3);
  for (int i = 0; i < 20; ++i) flat.push_back({mm(0.1 * i), 1e-3 + 1e-5 * random.normal()});
  EXPECT_FALSE(fit_focus_peak(flat, &reason));
  EXPECT_FALSE(reason.empty());
  for (FocusSample& sample : flat) sample.sharpness = -1e-6;
  EXPECT_FALSE(fit_focus_peak(flat, &reason));
  EXPECT_EQ(reason, "nothing is to be seen at any height");
  for (FocusSample& sample : flat) sample.sharpness = NAN;
  EXPECT_FALSE(fit_focus_peak(flat, &reason));
}

}  // namespace
}  // namespace panelcal
