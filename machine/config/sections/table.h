// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/config/settings/machine.h"
#include "machine/config/toml/toml_table.h"

// Not installed: a part of reading machine.toml.
namespace panelcal::internal {

/// Reads [table] and the calibration that it names: the walk's table and the uncertainty that comes
/// with it.
///
/// Fails  config-key-unknown; config-value; what read_table_calibration reports
Expected<void> read_table_config(const TomlTable& top, MachineConfig& config);

}  // namespace panelcal::internal
