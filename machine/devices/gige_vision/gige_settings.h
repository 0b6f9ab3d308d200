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

/// Fails  device-camera (see open_gige_camera)
Expected<ReadyCamera> set_up(const GigeAddress& address);

}  // namespace panelcal::internal
