// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "machine/devices/stage.h"
#include "program/walk/probing.h"

namespace panelcal {

/// The drive of a machine; all parts share one connection.
struct OpenedControl {
  std::shared_ptr<Stage> stage;        ///< never null; sets what [machine] lamp_command sets, too
  std::shared_ptr<ProbeSource> probe;  ///< null: the machine file states no probe
  std::string words;                   ///< for people: "GRBL 1.1h at /dev/ttyUSB0"; of commands ""
};

}  // namespace panelcal
