// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/rim_model.h"

#include <cmath>

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

RimVector ring_parameters() {
  RimVector p;
  p << 0.3, -0.2, 20, 1.1, 60, 5, -4, 100, 8, 6, 11, -20;
  return p;
}

TEST(RimModel, GradientAgreesWithDifferences) {
  constexpr double kStep = 1e-5;
  constexpr double kTolerance = 2e-4;  // of levels per px; the frame's scale is taken as constant
  const RimModel model(Shape::Ring, Eigen::Vector2d(0, 0), 20);
  Eigen::Matrix2d jacobian;
  jacobian << 1.01, 0.004, -0.003, 0.99;
  for (const double r : {9.5, 11.0, 12.5, 18.7, 20.0, 21.9}) {
    WindowPixel pixel;
    pixel.at = r * Eigen::Vector2d(0.6, 0.8);
    pixel.jacobian = jacobian;
    RimVector gradient = RimVector::Zero();
    model.evaluate(pixel, ring_parameters(), &gradient);
    for (int i = 0; i < model.n_parameters(); ++i) {
      RimVector high = ring_parameters();
      RimVector low = ring_parameters();
      high[i] += kStep;
      low[i] -= kStep;
      const double slope =
          (model.evaluate(pixel, high, nullptr).level - model.evaluate(pixel, low, nullptr).level) /
          (2 * kStep);
      // n turns with the centre, and with it the scale: a part of the gradient that is left out.
      const double tolerance = i <= kCenterY ? 0.05 : kTolerance;
      EXPECT_NEAR(gradient[i], slope, tolerance) << "parameter " << i << " at radius " << r;
    }
  }
}

TEST(RimModel, FarPixelsAreFlat) {
  const RimModel disc(Shape::Disc, Eigen::Vector2d(0, 0), 20);
  WindowPixel pixel;
  pixel.jacobian.setIdentity();
  pixel.at = {0.3, -0.2};  // the very centre, where no direction is defined
  EXPECT_EQ(disc.evaluate(pixel, ring_parameters(), nullptr).zone, RimModel::Zone::Inside);
  pixel.at = {40, 0};
  EXPECT_EQ(disc.evaluate(pixel, ring_parameters(), nullptr).zone, RimModel::Zone::Outside);
}

}  // namespace
}  // namespace panelcal::internal
