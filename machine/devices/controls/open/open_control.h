// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/devices/controls/control.h"

namespace panelcal {

/// Connects to the control of [machine] driver and reads its state; nothing moves, but for homing
/// where the machine file asks for it. Without a driver: [machine] stage_command and probe_command.
/// Neither stage nor probe goes outside [machine] travel_low_mm and travel_high_mm with a driver.
///
/// Precondition: config.can_move(), or can_probe() and the stage is not moved.
/// Fails  device-stage (no connection; a state in which the machine must not be moved, with what
///        to do about it); interrupted
Expected<OpenedControl> open_control(const MachineConfig& config);

}  // namespace panelcal
