// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/camera/fit/fit_input.h"
#include "calib/camera/model.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// One dot in one view: where it is seen, with derivatives.
struct DotProjection {
  Position<frame::Image> at;
  Eigen::Matrix<double, 2, kCameraParameters> by_camera;
  Eigen::Matrix<double, 2, 3> by_pose;
  Eigen::Matrix2d by_dot;
};

std::optional<DotProjection> project_dot(const CameraModel& camera,
                                         const PlatePose& pose,
                                         const Eigen::Vector2d& dot_mm,
                                         const Eigen::Vector2d& axis_at_mm,
                                         const Position<frame::Image>& near);

/// Makes residuals of this covariance ones of unit variance.
Eigen::Matrix2d whitening_of(const Eigen::Matrix2d& cov);

}  // namespace panelcal::internal
