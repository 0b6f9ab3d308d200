// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/config/settings/machine.h"
#include "machine/config/toml/toml_table.h"

namespace panelcal::internal {

/// Reads how the stage is driven from [machine]: stage_command, drill_command, lamp_command,
/// zoom_command, focus_command, command_limit_s, settle_s.
///
/// Fails  config-value (no program, a placeholder that is missing or has no meaning)
Expected<void> read_stage_config(const TomlTable& machine, MachineConfig& config);

}  // namespace panelcal::internal
