// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "calib/base/clock.h"

namespace panelcal {

/// The machine that is examined, and how far.
struct Examination {
  std::filesystem::path machine_toml;
  std::string camera;  ///< its address; empty: that of [nightly]
  /// Opens the camera and the control too. Opening a control may end what another program does with
  /// it: GRBL's serial device resets it, and linuxcncrsh gives the control to the newest client.
  bool opens_devices = false;
  Clock clock;
  std::string software;  ///< "panelcal 0.1.0"
  std::string asked_by;
};

}  // namespace panelcal
