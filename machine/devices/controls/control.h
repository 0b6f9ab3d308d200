// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/devices/stage.h"
#include "program/walk/probing.h"

namespace panelcal {

/// What a control of a machine offers; all parts share one connection.
struct OpenedControl {
  std::shared_ptr<Stage> stage;        ///< never null; sets what [machine] lamp_command sets, too
  std::shared_ptr<ProbeSource> probe;  ///< null: the machine file states no probe
  std::string words;                   ///< for people: "GRBL 1.1h at /dev/ttyUSB0"
};

/// Connects to the control of [machine] driver and reads its state; nothing moves.
///
/// Precondition: config.control.driver is there.
/// Fails  device-stage (no connection; a state in which the machine must not be moved, with what
///        to do about it); interrupted
Expected<OpenedControl> open_control(const MachineConfig& config);

}  // namespace panelcal
