// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "calib/correction/tolerance.h"
#include "machine/config/toml/toml_table.h"

namespace panelcal::internal {

/// Reads [tolerance] and [[tolerance.tool]]; nothing is asked without the table.
///
/// Fails  config-key-unknown; config-value (also a row that names no tool, or says both or neither
///        of position and pad, and a tool that two rows name)
/// See    tests/machine/config/sections/tolerance_test.cc
Expected<Tolerances> read_tolerances(const TomlTable& top);

}  // namespace panelcal::internal
