// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/config/settings/machine.h"
#include "machine/config/toml/toml_table.h"

// Not installed: parts of machine.toml.
namespace panelcal::internal {

/// Reads the [[vision.tool]] of [vision].
///
/// Precondition: [camera] has been read
/// Fails  config-value, with line and column, also of a target that no picture could tell, and of
///        two of one number; what reading a template's picture reports
Expected<void> read_targets(const TomlTable& vision, MachineConfig& config);

}  // namespace panelcal::internal
