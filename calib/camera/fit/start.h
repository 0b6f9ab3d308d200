// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/base/calibration_plate.h"
#include "calib/camera/fit/fit_input.h"
#include "calib/camera/model.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// Everything that a camera fit estimates.
struct CameraState {
  CameraModel::Parameters camera;
  std::vector<PlatePose> poses;
  std::vector<Eigen::Vector2d> dots_mm;
};

/// Start values for a camera that is flat, in closed form: scale and rotation from how pictures of
/// one dot move with the stage; failing that the scale from the certified dots of each view.
///
/// Precondition: data checked, at least one observation.
CameraState start_of(const CameraData& data, const CameraFitOptions& options);

}  // namespace panelcal::internal
