// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "machine/config/toml/toml_table.h"

namespace panelcal::internal {

/// Subject of a row of machine.toml: one tool, or all tools of a diameter.
struct ToolRow {
  std::optional<int> number;
  std::optional<Length> drill;
};

/// Reads `number` and `drill_mm` of a row.
///
/// Fails  config-value: neither, or no number of a tool, or a diameter that no drill has
/// See    tests/machine/config/sections/tolerance_test.cc
Expected<ToolRow> read_tool_row(const TomlTable& table);

/// The same of a row that says one of them alone.
///
/// Fails  config-value: both, too
/// See    tests/machine/config/sections/program_test.cc
Expected<ToolRow> read_single_tool_row(const TomlTable& table);

}  // namespace panelcal::internal
