// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/mapping.h"

#include <limits>
#include <numbers>

#include <gmock/gmock.h>

#include "tests/calib/panel/synthetic_panel.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::IsNearMatrix;
using test::IsNearPosition;

/// k1 bends the corner of a 640 x 480 picture by 1.6 px: much for a machine camera.
constexpr double kStrongLens_per_px2 = 2.5e-8;

CameraMapping::Parameters parameters(double k1_per_px2) {
  return {.scale_mm_per_px = 0.0125,
          .rotation_rad = 0.02,
          .axis_px = {319.3, 241.1},
          .k1_per_px2 = k1_per_px2};
}

TEST(CameraMapping, PutsTheAxisAtZero) {
  const CameraMapping mapping(parameters(kStrongLens_per_px2));
  EXPECT_EQ(mapping(position_px(319.3, 241.1)), position_mm<frame::Optical>(0, 0));
}

TEST(CameraMapping, TurnsThePictureUpsideUp) {
  const CameraMapping mapping({.scale_mm_per_px = 0.01, .axis_px = {100, 100}});
  constexpr Length kExact = um(1e-9);
  EXPECT_THAT(mapping(position_px(110, 100)),
              IsNearPosition(position_mm<frame::Optical>(0.1, 0), kExact));
  // Below the axis in the picture is towards the operator, negative y.
  EXPECT_THAT(mapping(position_px(100, 110)),
              IsNearPosition(position_mm<frame::Optical>(0, -0.1), kExact));
  // A camera turned counter-clockwise sees its own right hand side further along y.
  const CameraMapping turned(
      {.scale_mm_per_px = 0.01, .rotation_rad = std::numbers::pi / 2, .axis_px = {100, 100}});
  EXPECT_THAT(turned(position_px(110, 100)),
              IsNearPosition(position_mm<frame::Optical>(0, 0.1), kExact));
}

TEST(CameraMapping, BendsAsItsFormulaSays) {
  const CameraMapping mapping({.scale_mm_per_px = 0.01, .axis_px = {0, 0}, .k1_per_px2 = 1e-6});
  EXPECT_THAT(mapping(position_px(300, -400)),
              IsNearPosition(position_mm<frame::Optical>(3 * 1.25, 4 * 1.25), um(1e-9)));
}

TEST(CameraMapping, JacobianIsItsDerivative) {
  Random random(71);
  constexpr double kStep_px = 1e-3;
  for (const double k1_per_px2 : {0.0, kStrongLens_per_px2, -kStrongLens_per_px2}) {
    const CameraMapping mapping(parameters(k1_per_px2));
    for (int trial = 0; trial < 50; ++trial) {
      const Eigen::Vector2d u_px(random.uniform(0, 640), random.uniform(0, 480));
      Eigen::Matrix2d numeric;
      for (int axis = 0; axis < 2; ++axis) {
        const Eigen::Vector2d step_px = kStep_px * Eigen::Vector2d::Unit(axis);
        const auto above = mapping(position_px<frame::Image>(u_px + step_px));
        const auto below = mapping(position_px<frame::Image>(u_px - step_px));
        numeric.col(axis) = (above - below).in_mm() / (2 * kStep_px);
      }
      // Coordinates of 4 mm are rounded to 1e-15 mm.
      EXPECT_THAT(mapping.jacobian(position_px<frame::Image>(u_px)), IsNearMatrix(numeric, 1e-11));
    }
  }
}

TEST(CameraMapping, CarriesTheCovarianceOver) {
  const CameraMapping mapping(parameters(kStrongLens_per_px2));
  const PositionEstimate<frame::Image> u = {position_px(600, 30),
                                            Eigen::Vector2d(0.04, 0.01).asDiagonal()};
  const Eigen::Matrix2d j = mapping.jacobian(u.position);
  const PositionEstimate<frame::Optical> p = mapping(u);
  EXPECT_EQ(p.position, mapping(u.position));
  EXPECT_THAT(p.cov, IsNearMatrix((j * u.cov * j.transpose()).eval(), 1e-20));
}

TEST(CameraMapping, FindsThePixelOfEveryPoint) {
  Random random(72);
  for (const double k1_per_px2 :
       {0.0, kStrongLens_per_px2, -kStrongLens_per_px2, 1e-5, -1e-6, 1e-14}) {
    SCOPED_TRACE(k1_per_px2);
    const CameraMapping mapping(parameters(k1_per_px2));
    const double fold_px =
        k1_per_px2 < 0 ? 1 / std::sqrt(-3 * k1_per_px2) : std::numeric_limits<double>::infinity();
    for (int trial = 0; trial < 200; ++trial) {
      const Eigen::Vector2d u_px(random.uniform(-100, 740), random.uniform(-100, 580));
      if ((u_px - mapping.parameters().axis_px).norm() > 0.99 * fold_px) continue;
      const auto back = mapping.image_of(mapping(position_px<frame::Image>(u_px)));
      ASSERT_TRUE(back.has_value());
      EXPECT_THAT(back->in_px(), IsNearMatrix(u_px, 1e-10));
    }
  }
}

TEST(CameraMapping, FindsTheAxisItself) {
  const CameraMapping mapping(parameters(kStrongLens_per_px2));
  EXPECT_EQ(mapping.image_of(position_mm<frame::Optical>(0, 0)), position_px(319.3, 241.1));
}

TEST(CameraMapping, HasNoPixelBeyondTheFold) {
  // The fold of k1 = -1e-6 lies at 577.35 px and maps to 384.9 px, 3.849 mm.
  const CameraMapping mapping({.scale_mm_per_px = 0.01, .axis_px = {0, 0}, .k1_per_px2 = -1e-6});
  const auto before = mapping.image_of(position_mm<frame::Optical>(3.8489, 0));
  ASSERT_TRUE(before.has_value());
  EXPECT_NEAR(before->in_px().x(), 577, 5);
  EXPECT_FALSE(mapping.image_of(position_mm<frame::Optical>(3.8491, 0)).has_value());
  EXPECT_FALSE(mapping.image_of(position_mm<frame::Optical>(1e9, 1e9)).has_value());
}

TEST(CameraMapping, HasNoPixelForWhatIsNotANumber) {
  const CameraMapping mapping(parameters(0));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(mapping.image_of(position_mm<frame::Optical>(nan, 0)).has_value());
}

TEST(CameraMapping, KnowsHowItMovesWithItsParameters) {
  const CameraMapping::Parameters p{0.011, 0.7, {300, 250}, -6e-8};
  const Eigen::Vector<double, 5> step(1e-7, 1e-5, 1e-3, 1e-3, 1e-12);
  const auto moved = [&](int k, double sign) {
    Eigen::Vector<double, 5> v(
        p.scale_mm_per_px, p.rotation_rad, p.axis_px.x(), p.axis_px.y(), p.k1_per_px2);
    v[k] += sign * step[k];
    return CameraMapping({v[0], v[1], {v[2], v[3]}, v[4]});
  };
  for (const auto& u : {position_px(300., 250.), position_px(-0.5, 470.), position_px(512., 17.)}) {
    const CameraJacobian j = CameraMapping(p).by_parameters(u);
    for (int k = 0; k < 5; ++k) {
      const Eigen::Vector2d difference =
          (moved(k, 1)(u).in_mm() - moved(k, -1)(u).in_mm()) / (2 * step[k]);
      // Rounding of millimetres over the step, and of the rotation its curvature.
      EXPECT_LE((j.col(k) - difference).norm(), 1e-9 * j.col(k).norm() + 1e-14 / step[k]) << k;
    }
  }
}

}  // namespace
}  // namespace panelcal
