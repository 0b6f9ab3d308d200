// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "calib/camera/fit/fit_input.h"
#include "calib/camera/fit/start.h"
#include "calib/camera/model.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The data's information on the camera alone, in units of CameraModelCovariance, poses and dots
/// eliminated.
struct CameraInformation {
  CameraModelCovariance normal = CameraModelCovariance::Zero();
  CameraModelCovariance before = CameraModelCovariance::Zero();  ///< with poses and dots known
  int n_determined = 0;  ///< coordinates of poses and dots, less their gauge
};

/// Residuals of a state in the data, and their derivatives; `used` are indices of observations.
///
/// Residuals are the whitened seen minus fitted. Derivatives are analytic, of the state's camera in
/// the order of CameraParameter, then the pose (angle rad, shift mm), then the dot (mm):
///
///   du/d camera = -J^-1 dK/d camera     du/dp = J^-1     dp/d angle = R' dot     dp/d dot = R
class CameraProblem {
 public:
  /// Precondition: the data are checked.
  CameraProblem(const CameraData& data,
                std::vector<std::size_t> used,
                double huber_sigmas,
                const CameraModel::Parameters& start);

  /// Moves the free camera parameters, all poses and all dots that are not certified to the least
  /// sum. False if there is no such place in reach.
  bool solve(std::span<const CameraParameter> free, CameraState& state);

  CameraInformation information(const CameraState& state) const;
  double chi_square(const CameraState& state) const;

  /// Seen minus fitted, bias counted; NaN where the camera does not show the dot.
  Eigen::Vector2d residual_px(const CameraState& state, const CameraObservation& seen) const;

 private:
  const CameraData& data_;
  std::vector<std::size_t> used_;
  double huber_sigmas_;
  Eigen::Matrix<double, kCameraParameters, 1> unit_;  ///< of the inner camera parameters
  std::vector<Eigen::Vector2d> bias_px_;              ///< of each of `used_`, while solving
};

}  // namespace panelcal::internal
