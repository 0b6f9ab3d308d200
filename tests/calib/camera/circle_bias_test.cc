// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/circle_bias.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>

#include "tests/calib/camera/simulated_camera.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::IsNearMatrix;

TEST(CircleBias, IsThatOfTheImageOfTheWholeDisc) {
  for (const Eigen::Vector2d& place_mm :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(2.2, -1.1), Eigen::Vector2d(-1.5, 1.7)}) {
    const CameraModel camera(test::bent_camera());
    const auto center = position_mm<frame::Optical>(place_mm);
    const Position<frame::Image> u = *camera.image_of(center);
    const Length radius = mm(0.4);
    const Eigen::Vector2d bias_px =
        test::centroid_px(camera, center, radius) - camera.image_of(center)->in_px();
    // The fourth order, by (radius over the radius of curvature of the lens)^2.
    EXPECT_THAT(circle_bias(camera, u, radius).in_px(),
                IsNearMatrix(bias_px, 0.02 * bias_px.norm() + 1e-5));
    EXPECT_GT(bias_px.norm(), 0.004);
  }
}

TEST(CircleBias, OfATiltIsTheCenterOfTheEllipse) {
  CameraModel::Parameters p = test::straight_camera();
  p.tilt = {0.1, 0};
  p.focal_px = 2000;
  const CameraModel camera(p);
  // The picture of x on the panel is x / (stretch + slope x), so the two ends of a diameter lie
  // at r / (stretch + slope r) and -r / (stretch - slope r), and the ellipse midway.
  const double stretch = p.scale_mm_per_px * std::sqrt(1.01);
  const double slope = 0.1 / p.focal_px;
  const double r_mm = 0.5;
  const double middle_px = (r_mm / (stretch + slope * r_mm) - r_mm / (stretch - slope * r_mm)) / 2;
  const auto bias = circle_bias(camera, position_px(320, 240), mm(r_mm));
  EXPECT_NEAR(bias.in_px().x(), middle_px, 1e-4 * std::abs(middle_px));
  EXPECT_NEAR(bias.in_px().y(), 0, 1e-9);
  EXPECT_LT(middle_px, -0.1);
}

TEST(CircleBias, IsNoneForAFlatCameraAndForAPoint) {
  const CameraModel flat(test::straight_camera());
  EXPECT_THAT(circle_bias(flat, position_px(100, 100), mm(0.5)).in_px(),
              IsNearMatrix(Eigen::Vector2d(0, 0), 1e-9));
  const CameraModel bent(test::bent_camera());
  EXPECT_EQ(circle_bias(bent, position_px(100, 100), mm(0)).in_px(), Eigen::Vector2d(0, 0));
}

}  // namespace
}  // namespace panelcal
