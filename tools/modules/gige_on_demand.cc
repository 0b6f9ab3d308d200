// SPDX-License-Identifier: Apache-2.0
// GigE Vision cameras, by way of their module (see module.h). Built only where Aravis is there.
#include "tools/modules/gige_functions.h"
#include "tools/modules/module.h"

namespace panelcal {

bool has_gige_vision() {
  return true;
}

Expected<std::unique_ptr<CameraDevice>> open_gige_camera(const GigeAddress& address) {
  static const auto& functions = modules::load<modules::GigeFunctions>(modules::kGigeModule);
  return functions.open_gige_camera(address);
}

}  // namespace panelcal
