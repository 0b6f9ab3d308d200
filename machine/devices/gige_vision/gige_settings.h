// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "machine/devices/cameras/gige_camera.h"
#include "machine/devices/gige_vision/gige_objects.h"

namespace panelcal::internal {

/// A camera under our control, set up for one frame at each trigger.
struct ReadyCamera {
  Object<ArvCamera> camera;
  PictureSize size;
};

/// Sets the exposure that the address states, if it states one.
///
/// Fails  device-camera; code_outside (beyond the camera's bounds)
Expected<void> set_exposure(ArvCamera& camera, const GigeAddress& address, Code code_outside);

/// Fails  device-camera (see open_gige_camera)
Expected<ReadyCamera> set_up(const GigeAddress& address);

}  // namespace panelcal::internal
