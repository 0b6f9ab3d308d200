// SPDX-License-Identifier: Apache-2.0
#include "machine/config/sections/tolerance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "machine/config/toml/tool_row.h"

namespace panelcal::internal {
namespace {

using Words = std::string_view;

constexpr std::array<Words, 6> kToleranceKeys = {
    "hold_probability", "position_um", "too_deep_um", "too_shallow_um", "tool", "warn_probability"};
constexpr std::array<Words, 7> kToleranceToolKeys = {
    "drill_mm", "min_ring_um", "number", "pad_mm", "position_um", "too_deep_um", "too_shallow_um"};

constexpr double kMost_um = 1e5;
constexpr double kMaxTolerance_mm = 100;
constexpr Range kError_um{.low = 0, .high = kMost_um, .low_is_open = true};
constexpr Range kPadDiameter_mm{.low = 0, .high = kMaxTolerance_mm, .low_is_open = true};
constexpr Range kProbabilityRange{0, 1};

Expected<AnnularRing> read_ring(const TomlTable& table, double pad_mm) {
  PANELCAL_TRY(const double least_um, table.number_or("min_ring_um", {0, kMost_um}, 0));
  return AnnularRing{mm(pad_mm), um(least_um)};
}

Expected<DepthTolerance> read_depth_tolerance(const TomlTable& table) {
  DepthTolerance depth;
  PANELCAL_TRY(const auto shallow_um, table.number("too_shallow_um", kError_um));
  if (shallow_um) depth.too_shallow = um(*shallow_um);
  PANELCAL_TRY(const auto deep_um, table.number("too_deep_um", kError_um));
  if (deep_um) depth.too_deep = um(*deep_um);
  return depth;
}

Expected<ToolTolerance> read_toleranced_tool(const TomlTable& table) {
  ToolTolerance row;
  PANELCAL_TRY(const ToolRow tool, read_tool_row(table));
  row.number = tool.number;
  row.drill = tool.drill;
  PANELCAL_TRY(const auto position_um, table.number("position_um", kError_um));
  if (position_um) row.position = um(*position_um);
  PANELCAL_TRY(row.depth, read_depth_tolerance(table));
  PANELCAL_TRY(const auto pad_mm, table.number("pad_mm", kPadDiameter_mm));
  if (pad_mm && position_um) {
    return failure(table.problem("pad_mm", "position_um or pad_mm", "there are both"));
  }
  if (!pad_mm && !position_um && row.depth.is_empty()) {
    return failure(
        table.missing("position_um", "position_um, pad_mm, too_shallow_um or too_deep_um"));
  }
  if (pad_mm) {
    PANELCAL_TRY(row.ring, read_ring(table, *pad_mm));
  } else if (table.has("min_ring_um")) {
    return failure(table.problem("min_ring_um", "pad_mm beside it"));
  }
  return row;
}

bool is_same_toleranced_tool(const ToolTolerance& a, const ToolTolerance& b) {
  if (a.number || b.number) return a.number == b.number;
  return std::abs((*a.drill - *b.drill).in_um()) <= 1;
}

}  // namespace

Expected<Tolerances> read_tolerances(const TomlTable& top) {
  Tolerances tolerances;
  PANELCAL_TRY(const auto table, top.table("tolerance", "[tolerance]", {kToleranceKeys, {}}));
  if (!table) return tolerances;
  PANELCAL_TRY(const auto position_um, table->number("position_um", kError_um));
  if (position_um) tolerances.position = um(*position_um);
  PANELCAL_TRY(tolerances.depth, read_depth_tolerance(*table));
  PANELCAL_TRY(tolerances.warn_above,
               table->number_or("warn_probability", kProbabilityRange, tolerances.warn_above));
  PANELCAL_TRY(tolerances.hold_above,
               table->number_or("hold_probability", kProbabilityRange, tolerances.hold_above));
  if (tolerances.hold_above < tolerances.warn_above) {
    const Words key = table->has("hold_probability") ? "hold_probability" : "warn_probability";
    return failure(table->problem(key, "warn_probability at most hold_probability"));
  }
  PANELCAL_TRY(const auto rows,
               table->tables("tool", "[[tolerance.tool]]", {kToleranceToolKeys, {}}));
  for (const TomlTable& row : rows) {
    PANELCAL_TRY(const ToolTolerance tool, read_toleranced_tool(row));
    const auto same = [&](const ToolTolerance& other) {
      return is_same_toleranced_tool(tool, other);
    };
    if (std::ranges::any_of(tolerances.tools, same)) {
      return failure(row.problem(
          tool.number ? "number" : "drill_mm", "each tool once", "another row names it"));
    }
    tolerances.tools.push_back(tool);
  }
  if (!tolerances.asks_positions() && !tolerances.asks_depths()) {
    return failure(table->missing(
        "position_um", "position_um, too_shallow_um, too_deep_um or [[tolerance.tool]]"));
  }
  return tolerances;
}

}  // namespace panelcal::internal
