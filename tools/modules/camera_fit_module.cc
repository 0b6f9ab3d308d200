// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/fit/solver_log.h"
#include "tools/modules/camera_fit_functions.h"
#include "tools/modules/module.h"

namespace {

bool solve(panelcal::internal::CameraProblem& problem,
           std::span<const panelcal::CameraParameter> free,
           panelcal::internal::CameraState& state) {
  return problem.solve(free, state);
}

constexpr panelcal::modules::CameraFitFunctions kCameraFitFunctions = {.solve = &solve};

}  // namespace

extern "C" [[gnu::visibility("default")]] const PanelcalModule panelcal_module = {
    PANELCAL_VERSION, &kCameraFitFunctions, &panelcal::silence_solver_log};
