// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/calibration/shared_error.h"

#include <cmath>

#include "calib/base/statistics/linear_algebra.h"
#include <Eigen/Core>

namespace panelcal {
namespace {

/// Pixels along each side on which the combinations are weighed. Errors of a lens are smooth.
constexpr int kLattice = 9;

/// A root of a covariance, by its correlations: variances differ by thirty orders of magnitude.
CameraModelCovariance root_of(const CameraModelCovariance& cov) {
  const Eigen::Matrix<double, kCameraParameters, 1> sigma = cov.diagonal().cwiseMax(0).cwiseSqrt();
  CameraModelCovariance correlation = CameraModelCovariance::Zero();
  for (int i = 0; i < kCameraParameters; ++i) {
    for (int j = 0; j < kCameraParameters; ++j) {
      const double size = sigma[i] * sigma[j];
      if (size > 0) correlation(i, j) = cov(i, j) / size;
    }
  }
  const internal::Eigensystem modes = internal::eigensystem(correlation);
  const CameraModelCovariance vectors = modes.vectors;
  return sigma.asDiagonal() * vectors * modes.values.cwiseMax(0).cwiseSqrt().asDiagonal();
}

}  // namespace

SharedCameraError::SharedCameraError(const CameraCalibration& calibration)
    : is_simple_(!calibration.needs_model()),
      mapping_(calibration.mapping()),
      model_(calibration.model()),
      covariance_(calibration.covariance) {
  kept_.setZero();
  rest_.setZero();
  if (is_simple_) return;
  covariance_ = CameraCovariance::Identity();
  const CameraModelCovariance root = root_of(calibration.full->covariance);
  CameraModelCovariance weight = CameraModelCovariance::Zero();
  for (int row = 0; row < kLattice; ++row) {
    for (int column = 0; column < kLattice; ++column) {
      const double x_px = (calibration.picture_width_px - 1) * column / (kLattice - 1.0);
      const double y_px = (calibration.picture_height_px - 1) * row / (kLattice - 1.0);
      const CameraModelJacobian moved =
          model_.by_parameters(position_px<frame::Image>(Eigen::Vector2d(x_px, y_px))) * root;
      weight += moved.transpose() * moved;
    }
  }
  // Eigenvalues come in ascending order.
  const CameraModelCovariance vectors = internal::eigensystem(weight).vectors;
  rest_ = root * vectors.leftCols<3>();
  kept_ = root * vectors.rightCols<5>();
}

CameraJacobian SharedCameraError::by(const Position<frame::Image>& u) const {
  if (is_simple_) return mapping_.by_parameters(u);
  return model_.by_parameters(u) * kept_;
}

Eigen::Matrix2d SharedCameraError::rest_mm2(const Position<frame::Image>& u) const {
  if (is_simple_) return Eigen::Matrix2d::Zero();
  const Eigen::Matrix<double, 2, 3> moved = model_.by_parameters(u) * rest_;
  return moved * moved.transpose();
}

}  // namespace panelcal
