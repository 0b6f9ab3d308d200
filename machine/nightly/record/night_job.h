// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/clock.h"
#include "machine/config/settings/machine.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/devices/calibration_devices.h"
#include "machine/nightly/record/night_lock.h"

namespace panelcal {

/// The input of a night.
struct NightJob {
  const MachineConfig& config;
  const NightlyConfig& nightly;
  CalibrationDevices devices;
  Clock clock;
  std::string software;  ///< "panelcal 0.1.0"
  std::string asked_by;  ///< a user, a timer
  bool is_dry_run = false;
  /// Calibrate again what this night has calibrated already (the lens has been cleaned since).
  bool is_again = false;
  std::optional<double> temperature_c = {};             ///< absent: read as [nightly] states
  std::function<void(std::string_view)> progress = {};  ///< a line each; empty: no output
  /// The machine's, if the caller holds it already: from before the devices were opened.
  const NightLock* lock = nullptr;
  std::vector<std::string> notes = {};  ///< events before, for the record
};

}  // namespace panelcal
