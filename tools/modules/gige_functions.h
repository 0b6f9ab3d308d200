// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "machine/devices/cameras/gige_camera.h"

namespace panelcal::modules {

inline constexpr const char* kGigeModule = "libpanelcal_gige.so";

/// GigE Vision cameras. Aravis, with GLib and libxml2.
struct GigeFunctions {
  decltype(&panelcal::open_gige_camera) open_gige_camera;
};

}  // namespace panelcal::modules
