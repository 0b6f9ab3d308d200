// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"

namespace panelcal {

/// Lets the spindle-camera offset drift until now, whichever clock its date is by.
///
/// Fails  config-value (it was found after now)
Expected<void> age_offset(MachineConfig& config, std::chrono::sys_seconds now_utc);

/// The same until the time of --clock, on the wall where this computer stands; until `now_utc` if
/// that is empty.
///
/// In     clock: empty, or as wall_time() accepts it
/// Fails  usage; config-value
Expected<void> age_offset(MachineConfig& config,
                          const std::string& clock,
                          std::chrono::sys_seconds now_utc);

}  // namespace panelcal
