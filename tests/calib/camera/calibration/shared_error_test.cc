// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/calibration/shared_error.h"

#include <cmath>

#include <gmock/gmock.h>

#include "tests/calib/camera/simulated_camera.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

/// Eight sigmas, as 25 views of a mark leave them, correlated.
CameraModelCovariance covariance_of(const Eigen::Matrix<double, kCameraParameters, 1>& sigma) {
  CameraModelCovariance correlation = CameraModelCovariance::Constant(0.3);
  correlation.diagonal().setOnes();
  return sigma.asDiagonal() * correlation * sigma.asDiagonal();
}

CameraCalibration calibration(const CameraModelCovariance& cov) {
  FullCamera camera;
  camera.form = CameraForm::Tangential;
  camera.parameters = test::bent_camera();
  camera.covariance = cov;
  return calibration_of(camera, 640, 480);
}

Eigen::Matrix<double, kCameraParameters, 1> usual_sigmas() {
  Eigen::Matrix<double, kCameraParameters, 1> sigma;
  sigma << 1e-7, 1e-5, 2e-4, 2e-4, 2e-10, 1e-15, 1e-8, 1e-8;
  return sigma;
}

TEST(SharedCameraError, OfASimpleCameraIsItsFiveParameters) {
  CameraCalibration c;
  c.parameters = {
      .scale_mm_per_px = 0.01, .rotation_rad = 0.1, .axis_px = {310, 250}, .k1_per_px2 = 1e-8};
  c.covariance.diagonal() << 1e-14, 1e-10, 4e-4, 9e-4, 1e-20;
  c.picture_width_px = 640;
  c.picture_height_px = 480;
  const SharedCameraError error(c);
  const auto u = position_px<frame::Image>(Eigen::Vector2d(17, 400));
  EXPECT_EQ(error.covariance(), c.covariance);
  EXPECT_EQ(error.by(u), c.mapping().by_parameters(u));
  EXPECT_EQ(error.rest_mm2(u), Eigen::Matrix2d::Zero());
}

TEST(SharedCameraError, LeavesNothingOutOfFiveFreeParameters) {
  auto sigma = usual_sigmas();
  sigma.tail<3>().setZero();  // k2, p1, p2 are held
  const CameraCalibration c = calibration(covariance_of(sigma));
  const SharedCameraError error(c);
  // Of two places together, since it is shared: 4 x 4.
  const auto u = position_px<frame::Image>(Eigen::Vector2d(30, 20));
  const auto v = position_px<frame::Image>(Eigen::Vector2d(600, 300));
  Eigen::Matrix<double, 4, kCameraParameters> j;
  j << c.model().by_parameters(u), c.model().by_parameters(v);
  Eigen::Matrix<double, 4, 5> kept;
  kept << error.by(u), error.by(v);
  const Eigen::Matrix4d expected = j * c.full->covariance * j.transpose();
  const Eigen::Matrix4d found = kept * error.covariance() * kept.transpose();
  EXPECT_THAT((found / expected.norm()).eval(),
              test::IsNearMatrix((expected / expected.norm()).eval(), 1e-9));
  EXPECT_LT(error.rest_mm2(u).norm(), 1e-9 * expected.norm());
}

TEST(SharedCameraError, OfEightParametersEveryPlaceStillHasItsWholeVariance) {
  const CameraCalibration c = calibration(covariance_of(usual_sigmas()));
  const SharedCameraError error(c);
  for (const double x_px : {0.0, 100.0, 320.0, 639.0}) {
    for (const double y_px : {0.0, 240.0, 479.0}) {
      const auto u = position_px<frame::Image>(Eigen::Vector2d(x_px, y_px));
      const CameraModelJacobian j = c.model().by_parameters(u);
      const Eigen::Matrix2d expected = j * c.full->covariance * j.transpose();
      const CameraJacobian by = error.by(u);
      const Eigen::Matrix2d rest = error.rest_mm2(u);
      const Eigen::Matrix2d found = by * error.covariance() * by.transpose() + rest;
      EXPECT_THAT(found, test::IsNearMatrix(expected, 1e-9 * expected.norm()));
    }
  }
  // At a corner nearly all of it is shared.
  const auto corner = position_px<frame::Image>(Eigen::Vector2d(0, 0));
  const CameraModelJacobian j = c.model().by_parameters(corner);
  const double whole = (j * c.full->covariance * j.transpose()).trace();
  EXPECT_LT(error.rest_mm2(corner).trace(), 0.1 * whole);
}

}  // namespace
}  // namespace panelcal
