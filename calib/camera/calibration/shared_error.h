// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/frames.h"
#include "calib/base/machine_uncertainty.h"
#include "calib/camera/calibration/calibration_file.h"
#include "calib/camera/model.h"
#include <Eigen/Core>

namespace panelcal {

/// Shift of all that the camera sees by an error of its calibration, in five numbers.
///
///   error of a place = by(u) e,   e ~ N(0, covariance())
///
/// For the simple form e are the errors of its five parameters. A full camera has eight; then e are
/// those five combinations of them, of variance 1, that move the places of the picture most. Of up
/// to five free parameters nothing is left out; what the others leave is rest_mm2(u), which is
/// counted for each target by itself.
///
/// See    tests/calib/camera/calibration/shared_error_test.cc
class SharedCameraError {
 public:
  /// Precondition: a calibration that its reader would accept
  explicit SharedCameraError(const CameraCalibration& calibration);

  const CameraCovariance& covariance() const { return covariance_; }
  CameraJacobian by(const Position<frame::Image>& u) const;
  Eigen::Matrix2d rest_mm2(const Position<frame::Image>& u) const;

 private:
  bool is_simple_;
  CameraMapping mapping_;
  CameraModel model_;
  CameraCovariance covariance_;
  Eigen::Matrix<double, kCameraParameters, 5> kept_;
  Eigen::Matrix<double, kCameraParameters, 3> rest_;
};

}  // namespace panelcal
