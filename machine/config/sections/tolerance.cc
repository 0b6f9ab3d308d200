// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string_view>

#include "machine/config/sections/sections.h"
#include "machine/config/toml/tool_row.h"

namespace panelcal::internal {
namespace {

/// A row of [[tolerance.tool]], with a ring as it is written.
struct ToleranceKeys {
  ToolTolerance tool;
  std::optional<Length> pad;
  Length min_ring;
};

constexpr double kMost_um = 1e5;
constexpr Range kError_um{.low = 0, .high = kMost_um, .low_is_open = true};
constexpr Range kPadDiameter_mm{.low = 0, .high = 100, .low_is_open = true};
constexpr Range kProbability{0, 1};

#include "machine/config/sections/tolerance.def"

Expected<ToolTolerance> read_toleranced_tool(const TomlTable& table) {
  ToleranceKeys keys;
  PANELCAL_CHECK(check_names_tool(table));
  PANELCAL_CHECK(table.read(kToleranceTool, keys));
  ToolTolerance& row = keys.tool;
  if (keys.pad && row.position) {
    return failure(table.problem("pad_mm", "position_um or pad_mm", "there are both"));
  }
  if (!keys.pad && !row.position && row.depth.is_empty()) {
    return failure(
        table.missing("position_um", "position_um, pad_mm, too_shallow_um or too_deep_um"));
  }
  if (!keys.pad && table.has("min_ring_um")) {
    return failure(table.problem("min_ring_um", "pad_mm beside it"));
  }
  if (keys.pad) row.ring = AnnularRing{*keys.pad, keys.min_ring};
  return row;
}

Expected<void> read_tolerances(const TomlTable& top, MachineConfig& config) {
  Tolerances& tolerances = config.walk.tolerances;
  PANELCAL_TRY(const auto table, top.read_table(kTolerance, tolerances));
  if (!table) return {};
  if (tolerances.hold_above < tolerances.warn_above) {
    const bool has_hold = table->has("hold_probability");
    return failure(table->problem(has_hold ? "hold_probability" : "warn_probability",
                                  "warn_probability at most hold_probability"));
  }
  PANELCAL_TRY(const auto rows, table->tables(kToleranceTool));
  for (const TomlTable& row : rows) {
    PANELCAL_TRY(const ToolTolerance tool, read_toleranced_tool(row));
    PANELCAL_CHECK(add_tool_row(row, tool, is_within_um, tolerances.tools));
  }
  if (!tolerances.asks_positions() && !tolerances.asks_depths()) {
    return failure(table->missing(
        "position_um", "position_um, too_shallow_um, too_deep_um or [[tolerance.tool]]"));
  }
  return {};
}

}  // namespace

Section tolerance_section() {
  return {kToleranceTables, read_tolerances};
}

}  // namespace panelcal::internal
