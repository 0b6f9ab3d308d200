// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "panelcal/calib/base/expected.h"
#include "panelcal/calib/tolerance.h"
#include "panelcal/machine/toml_table.h"

namespace panelcal::internal {

/// Reads [tolerance] and [[tolerance.tool]]; nothing is asked without the table.
///
/// Fails  config-key-unknown; config-value (also a row that names no tool, or says both or neither
///        of position and pad, and a tool that two rows name)
/// See    tests/machine/tolerance_config_test.cc
Expected<Tolerances> read_tolerances(const TomlTable& top);

}  // namespace panelcal::internal
