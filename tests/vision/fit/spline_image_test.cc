// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/spline_image.h"

#include <cmath>

#include "calib/base/statistics/random.h"
#include "vision/fit/raster_filter.h"
#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

TEST(SplineImage, PassesThroughItsPixels) {
  Random random(1);
  Raster raster(19, 13);
  for (double& v : raster.values) v = random.normal();
  const SplineImage spline(raster);
  for (int y = 1; y < 11; ++y) {
    for (int x = 1; x < 17; ++x) {
      EXPECT_NEAR(spline({x, y}).value, raster.at(x, y), 1e-12);
    }
  }
}

/// A cubic spline reproduces cubic polynomials exactly, away from the mirrored border.
TEST(SplineImage, IsExactForCubicsWithTheirSlopes) {
  const auto f = [](double x, double y) { return 0.001 * x * x * x - 0.02 * x * y * y + y; };
  Raster raster(61, 61);
  for (int y = 0; y < 61; ++y) {
    for (int x = 0; x < 61; ++x) raster.at(x, y) = f(x - 30, y - 30);
  }
  const SplineImage spline(raster);
  for (const double at : {29.0, 30.25, 31.7}) {
    const SplineValue v = spline({at, at + 0.4});
    const double x = at - 30;
    const double y = at - 29.6;
    EXPECT_NEAR(v.value, f(x, y), 1e-9);
    EXPECT_NEAR(v.dx, 0.003 * x * x - 0.02 * y * y, 1e-9);
    EXPECT_NEAR(v.dy, -0.04 * x * y + 1, 1e-9);
  }
}

TEST(SplineImage, BlurAddsItsVarianceAndKeepsTheSum) {
  Raster raster(41, 41);
  raster.at(20, 20) = 1;
  const Raster out = blurred(raster, 1.5);
  double sum = 0;
  double second = 0;
  for (int y = 0; y < 41; ++y) {
    for (int x = 0; x < 41; ++x) {
      sum += out.at(x, y);
      second += out.at(x, y) * (x - 20) * (x - 20);
    }
  }
  EXPECT_NEAR(sum, 1, 1e-12);
  EXPECT_NEAR(second, 2.25, 0.01);
}

}  // namespace
}  // namespace panelcal::internal
