// SPDX-License-Identifier: Apache-2.0
// Takes the place of gige_camera.cc where Aravis is missing at build time.
#include "machine/devices/cameras/gige_camera.h"

namespace panelcal {

bool has_gige_vision() {
  return false;
}

Expected<std::unique_ptr<CameraDevice>> open_gige_camera(const GigeAddress& address) {
  return failure({Code::DeviceCamera,
                  {"gige://" + address.address, 0, 0},
                  "this panelcal was built without Aravis and has no GigE Vision",
                  "a build with libaravis-dev and libusb-1.0-0-dev"});
}

}  // namespace panelcal
