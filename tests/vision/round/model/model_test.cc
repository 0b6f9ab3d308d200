// SPDX-License-Identifier: Apache-2.0
#include "vision/round/model/model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "vision/fit/frame.h"
#include <gtest/gtest.h>

#include "tests/vision/round/model/rim_value.h"
#include "tests/vision/trial.h"

namespace panelcal::internal {
namespace {

RimVector ring_parameters() {
  RimVector p = RimVector::Zero();
  p[kCenterX] = 0.3;
  p[kCenterY] = -0.2;
  p[kRadius] = 20;
  p[kSigma] = 1.1;
  p[kLevel] = 60;
  p[kLightX] = 0.08;
  p[kLightY] = -0.05;
  p[kContrast] = 100;
  p[kInnerRadius] = 9;
  p[kHole] = -20;
  p[kHoleX] = 1.2;
  p[kHoleY] = -0.7;
  p[kContrastX] = 3;
  p[kContrastY] = -2;
  return p;
}

/// A lens that bends 20 times more than a machine's, so that the Jacobian is no multiple of a turn.
CameraMapping bent_mapping() {
  return CameraMapping({.scale_mm_per_px = 0.01,
                        .rotation_rad = 0.2,
                        .axis_px = Eigen::Vector2d(-80, 60),
                        .k1_per_px2 = 2e-6});
}

RimPixel pixel_at(const FitFrame& frame, const Eigen::Vector2d& u) {
  RimPixel pixel;
  pixel.at = frame.from_image(u).cast<float>();
  pixel.jacobian = frame.jacobian(u).cast<float>();
  pixel.plane = (u / 20).cast<float>();
  return pixel;
}

/// Central differences and the gradient at pixels all around both rims.
///
/// In     turning: what the gradient of the places leaves out, as part of the steepest slope
void expect_gradient(const RimVector& p, bool is_ring, double turning) {
  constexpr double kStep = 1e-5;
  constexpr double kDifferences = 1e-4;  // levels per unit: the slope of the table of the edge
  const CameraMapping mapping = bent_mapping();
  const FitFrame frame(&mapping, Eigen::Vector2d(0, 0));
  const double steepest = (std::abs(p[kContrast]) + std::abs(p[kHole])) / (2 * p[kSigma]);
  int n_steep = 0;
  for (int y = -24; y <= 24; y += 2) {
    for (int x = -24; x <= 24; ++x) {
      const RimPixel pixel = pixel_at(frame, Eigen::Vector2d(x, y));
      if (pixel.at.norm() < 3) continue;  // nearly no direction there
      RimGradient gradient{};
      const RimValue value = rim_value(pixel, p, is_ring, &gradient);
      n_steep += value.share > 0.1 && value.share < 0.9;
      for (int i = 0; i < kRimParameters; ++i) {
        const bool is_of_ring = i >= kInnerRadius && i < kOval;
        if (is_of_ring && !is_ring) continue;
        RimVector high = p;
        RimVector low = p;
        high[i] += kStep;
        low[i] -= kStep;
        const RimValue above = rim_value(pixel, high, is_ring, nullptr);
        const RimValue below = rim_value(pixel, low, is_ring, nullptr);
        // At the cut-off foot of the edge the level jumps by 1e-8 of the contrast.
        if ((above.share == 0) != (below.share == 0)) continue;
        if ((above.share == 1) != (below.share == 1)) continue;
        const double slope = (above.level - below.level) / (2 * kStep);
        const bool is_place = i == kCenterX || i == kCenterY || i == kHoleX || i == kHoleY;
        const bool is_radius = i == kRadius || i == kInnerRadius;
        const double oval = 2 * std::hypot(p[kOval], p[kOvalDiagonal]);
        const double left_out = is_place ? turning + oval : is_radius ? oval : 0;
        // An oval's derivative counts a whole radius.
        const double unit = i == kOval || i == kOvalDiagonal ? p[kRadius] : 1;
        EXPECT_NEAR(
            gradient[static_cast<std::size_t>(i)], slope, left_out * steepest + unit * kDifferences)
            << "parameter " << i << " at pixel " << x << " " << y;
      }
    }
  }
  EXPECT_GT(n_steep, 50);
}

/// The direction of the rim turns with the centre, and with it the local scale, which only differs
/// by what the lens bends: left out of the gradient.
constexpr double kTurning = 0.02;

TEST(RimModel, GradientOfADiscAgreesWithDifferences) {
  expect_gradient(ring_parameters(), false, kTurning);
}

TEST(RimModel, GradientOfARingAgreesWithDifferences) {
  expect_gradient(ring_parameters(), true, kTurning);
}

TEST(RimModel, GradientOfAnOvalRingAgreesWithDifferences) {
  RimVector p = ring_parameters();
  p[kOval] = 0.011;
  p[kOvalDiagonal] = -0.007;
  expect_gradient(p, true, kTurning);
}

TEST(RimModel, GradientOfASharpDarkDiscAgreesWithDifferences) {
  RimVector p = ring_parameters();
  p[kSigma] = 0.45;
  p[kLevel] = 180;
  p[kContrast] = -130;
  // A pixel's square shows more at sharp edges: its cumulant depends on the direction.
  expect_gradient(p, false, 2 * kTurning);
}

TEST(RimModel, ZoneLevelsAreTheModelFarFromItsRims) {
  const RimVector p = ring_parameters();
  const FitFrame frame(nullptr, Eigen::Vector2d(0, 0));
  struct Place {
    Eigen::Vector2d u;
    RimZone zone;
  };
  for (const Place& place : {Place{{1, -1}, RimZone::Hole},
                             Place{{-14.6, 1}, RimZone::Target},
                             Place{{-19, -26}, RimZone::Outside}}) {
    const RimPixel pixel = pixel_at(frame, place.u);
    RimGradient gradient{};
    const RimValue value = rim_value(pixel, p, true, &gradient);
    const Eigen::Vector3d b(
        1, static_cast<double>(pixel.plane.x()), static_cast<double>(pixel.plane.y()));
    constexpr double kFoot = 1e-3;  // levels; of the rims, which are 4 sigmas away at least
    EXPECT_NEAR(b.dot(zone_level(p, place.zone)), value.level, kFoot);
    const RimVector slope = zone_level_jacobian(p, place.zone).transpose() * b;
    for (const int i : {kLevel, kLightX, kLightY, kContrast, kHole, kContrastX, kContrastY}) {
      EXPECT_NEAR(slope[i], gradient[static_cast<std::size_t>(i)], kFoot) << i;
    }
  }
}

TEST(RimModel, FarPixelsAreFlat) {
  const RimVector p = ring_parameters();
  RimPixel pixel;
  pixel.jacobian.setIdentity();
  pixel.plane.setZero();
  pixel.at = {0.3F, -0.2F};  // the very centre, where no direction is defined
  RimValue value = rim_value(pixel, p, false, nullptr);
  EXPECT_EQ(value.share, 1);
  EXPECT_EQ(value.level, 160);
  EXPECT_GT(value.distance_px, 19.999);  // never taken for the rim
  pixel.at = {40, 0};
  value = rim_value(pixel, p, false, nullptr);
  EXPECT_EQ(value.share, 0);
  EXPECT_EQ(value.level, 60);
}

TEST(RimModel, FreedomListsWhatIsFree) {
  std::array<int, kRimParameters> columns{};
  EXPECT_EQ(RimFreedom{}.columns(columns), 8);
  EXPECT_EQ(columns[7], kContrast);
  const RimFreedom all{.is_ring = true, .is_oval = true, .has_own_slope = true};
  ASSERT_EQ(all.columns(columns), kRimParameters);
  for (int i = 0; i < kRimParameters; ++i) EXPECT_EQ(columns[static_cast<std::size_t>(i)], i);
  const RimFreedom oval{.is_ring = false, .is_oval = true, .has_own_slope = false};
  ASSERT_EQ(oval.columns(columns), 10);
  EXPECT_EQ(columns[8], kOval);
  EXPECT_EQ(columns[9], kOvalDiagonal);
}

/// A ring with an off-centre hole in uneven light behind a lens: exact, and as the model has it.
TEST(RimModel, AgreesWithTheExactPicture) {
  constexpr int kExactSide = 120;
  constexpr double kRadiusPx = 30;
  constexpr double kHolePx = 13;
  const CameraMapping mapping({.scale_mm_per_px = 0.01,
                               .rotation_rad = 0.1,
                               .axis_px = Eigen::Vector2d(-100, 40),
                               .k1_per_px2 = 1.5 / std::pow(400.0, 3)});
  const Eigen::Vector2d center_px(59.3, 60.8);
  Feature ring;
  ring.shape = Feature::Shape::Ring;
  ring.center = mapping(position_px<frame::Image>(center_px));
  ring.size = mm(2 * kRadiusPx * 0.01);
  ring.inner_size = mm(2 * kHolePx * 0.01);
  ring.hole_offset = displacement_mm<frame::Optical>(Eigen::Vector2d(0.03, -0.02));
  ring.level = 0.7;
  Scene scene;
  scene.background = 0.3;
  scene.features = {ring};
  const Camera camera{
      .mapping = mapping, .width = kExactSide, .height = kExactSide, .blur_px = 1.0};
  const std::vector<double> exact = render_levels(scene, camera);

  const FitFrame frame(&mapping, center_px);
  RimVector p = RimVector::Zero();
  p[kRadius] = kRadiusPx;
  p[kSigma] = std::sqrt(1 + kPixelVariance);
  p[kLevel] = 0.3 * 255;
  p[kContrast] = 0.4 * 255;
  p[kInnerRadius] = kHolePx;
  p[kHoleX] = 3;
  p[kHoleY] = -2;
  double worst = 0;
  for (int y = 0; y < kExactSide; ++y) {
    for (int x = 0; x < kExactSide; ++x) {
      const RimPixel pixel = pixel_at(frame, Eigen::Vector2d(x, y));
      const double level = rim_value(pixel, p, true, nullptr).level;
      worst =
          std::max(worst, std::abs(level - exact[static_cast<std::size_t>(y * kExactSide + x)]));
    }
  }
  // The profile's promise for radii above 8 is 1e-4 of the contrast; the inner rim has 13, the lens
  // bends the rest.
  EXPECT_LT(worst, 2e-3 * 0.4 * 255);
  EXPECT_GT(worst, 0);
}

}  // namespace
}  // namespace panelcal::internal
