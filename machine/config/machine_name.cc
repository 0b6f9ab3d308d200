// SPDX-License-Identifier: Apache-2.0
#include "machine/config/machine_name.h"

namespace panelcal {

std::string machine_name(const MachineConfig& config) {
  return config.name.empty() ? "machine" : config.name;
}

}  // namespace panelcal
