// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/devices/stage.h"
#include "program/walk/probing.h"

namespace panelcal {

/// The drive of a machine; all parts share one connection.
struct OpenedControl {
  std::shared_ptr<Stage> stage;        ///< never null; sets what [machine] lamp_command sets, too
  std::shared_ptr<ProbeSource> probe;  ///< null: the machine file states no probe
  std::string words;                   ///< for people: "GRBL 1.1h at /dev/ttyUSB0"; of commands ""
};

/// Connects to the control of [machine] driver and reads its state; nothing moves, but for homing
/// where the machine file asks for it. Without a driver: [machine] stage_command and probe_command.
/// Neither stage nor probe goes outside [machine] travel_low_mm and travel_high_mm with a driver.
///
/// Precondition: config.can_move(), or can_probe() and the stage is not moved.
/// Fails  device-stage (no connection; a state in which the machine must not be moved, with what
///        to do about it); interrupted
Expected<OpenedControl> open_control(const MachineConfig& config);

}  // namespace panelcal
