// SPDX-License-Identifier: Apache-2.0
// The one function of panelcal::camera that needs Ceres, by way of its module (see module.h).
#include "tools/modules/camera_fit_functions.h"
#include "tools/modules/module.h"

namespace panelcal::internal {

bool CameraProblem::solve(std::span<const CameraParameter> free, CameraState& state) {
  static const auto& functions =
      modules::load<modules::CameraFitFunctions>(modules::kCameraFitModule);
  return functions.solve(*this, free, state);
}

}  // namespace panelcal::internal
