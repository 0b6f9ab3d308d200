// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/config/settings/machine.h"
#include "machine/config/toml/toml_table.h"

namespace panelcal::internal {

/// Reads what a machine.toml says about reading and executing programs: [program],
/// [surface], [reference_scaling] and [[diameter_page]].
///
/// In     top: the whole file; config.file is where search paths are relative to
Expected<void> read_program_config(const TomlTable& top, MachineConfig& config);

/// Reads the keys travel_low_mm and travel_high_mm of [machine].
Expected<void> read_travel(const TomlTable& machine, MachineConfig& config);

}  // namespace panelcal::internal
