// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "machine/config/settings/machine.h"

namespace panelcal {

/// As the ledger calls it: "machine" for one without a name.
std::string machine_name(const MachineConfig& config);

}  // namespace panelcal
