// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "calib/camera/fit/problem.h"

namespace panelcal::modules {

inline constexpr const char* kCameraFitModule = "libpanelcal_camera_fit.so";

/// The solver of camera calibrations. Ceres, with glog, SuiteSparse and LAPACK.
struct CameraFitFunctions {
  bool (*solve)(internal::CameraProblem& problem,
                std::span<const CameraParameter> free,
                internal::CameraState& state);
};

}  // namespace panelcal::modules
