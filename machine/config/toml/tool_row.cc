// SPDX-License-Identifier: Apache-2.0
#include "machine/config/toml/tool_row.h"

#include "machine/config/toml/ranges.h"

namespace panelcal::internal {
namespace {

constexpr Range kDrillDiameter_mm{.low = 0, .high = 100, .low_is_open = true};

}  // namespace

Expected<ToolRow> read_tool_row(const TomlTable& table) {
  ToolRow row;
  PANELCAL_TRY(const auto number, table.integer("number", 1, kMaxToolNumber));
  if (number) row.number = static_cast<int>(*number);
  PANELCAL_TRY(const auto drill_mm, table.number("drill_mm", kDrillDiameter_mm));
  if (drill_mm) row.drill = mm(*drill_mm);
  if (!number && !drill_mm) return failure(table.missing("number", "number, or drill_mm"));
  return row;
}

Expected<ToolRow> read_single_tool_row(const TomlTable& table) {
  PANELCAL_TRY(const ToolRow row, read_tool_row(table));
  if (!row.number || !row.drill) return row;
  return failure(table.problem("drill_mm", "number or drill_mm", "there are both"));
}

}  // namespace panelcal::internal
