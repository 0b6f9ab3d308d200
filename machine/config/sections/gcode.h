// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/base/expected.h"
#include "machine/config/toml/toml_table.h"
#include "program/writers/gcode/setting.h"

namespace panelcal::internal {

/// Reads [gcode] and [[gcode.tool]]; empty without the table.
///
/// Fails  config-key-unknown; config-value (also heights in the wrong order, a row that names no
///        tool or says nothing, and a tool that two rows name)
/// See    tests/machine/config/sections/gcode_test.cc
Expected<std::optional<GcodeSetting>> read_gcode_config(const TomlTable& top);

}  // namespace panelcal::internal
