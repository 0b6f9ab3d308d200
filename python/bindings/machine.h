// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "machine/config/machine_config.h"

namespace panelcal::python {

/// A machine as its file describes it. Nothing changes it, so that threads may share it.
struct Machine {
  std::shared_ptr<const MachineConfig> config;
};

}  // namespace panelcal::python
