// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string_view>

#include "machine/config/sections/sections.h"
#include "machine/config/toml/tool_row.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr Range kStroke_mm{.low = 0, .high = kMaxPlace_mm, .low_is_open = true};
/// A feed that rounds to 0 in a program's digits would be no feed at all.
constexpr Range kRate_mm_s{1e-3, 1e5};
constexpr Range kSpeed_rpm{1, 1e7};

#include "machine/config/sections/gcode.def"

/// A height that the tool works at, or that lies in its way, has to be below where it moves
/// rapidly.
Expected<void> check_below(const TomlTable& table,
                           std::string_view key,
                           const std::optional<Length>& z,
                           const GcodeSetting& setting) {
  const Length rapid = setting.approach_z.value_or(setting.safe_z);
  if (!z || *z < rapid) return {};
  return failure(table.problem(key,
                               fmt::format("less than {} ({:g})",
                                           setting.approach_z ? "approach_z_mm" : "safe_z_mm",
                                           rapid.in_mm())));
}

Expected<void> check_work(const TomlTable& table,
                          const GcodeWork& work,
                          const GcodeSetting& setting) {
  PANELCAL_CHECK(check_below(table, "drill_z_mm", work.drill_z, setting));
  return check_below(table, "rout_z_mm", work.rout_z, setting);
}

Expected<void> check_heights(const TomlTable& table, const GcodeSetting& setting) {
  if (setting.approach_z && *setting.approach_z > setting.safe_z) {
    return failure(table.problem("approach_z_mm", "at most safe_z_mm"));
  }
  if (setting.change_z && *setting.change_z < setting.safe_z) {
    return failure(table.problem("change_z_mm", "at least safe_z_mm"));
  }
  PANELCAL_CHECK(check_below(table, "table_z_mm", setting.table_z, setting));
  return check_below(table, "board_z_mm", setting.board_z, setting);
}

Expected<GcodeTool> read_gcode_tool(const TomlTable& table, const GcodeSetting& setting) {
  GcodeTool row;
  PANELCAL_CHECK(check_names_one_tool(table));
  PANELCAL_CHECK(table.read(kGcodeTool, row));
  if (row.work == GcodeWork()) {
    return failure(table.missing("drill_z_mm", "drill_z_mm, infeed_mm_s or another of [gcode]"));
  }
  PANELCAL_CHECK(check_work(table, row.work, setting));
  return row;
}

Expected<void> read_gcode(const TomlTable& top, MachineConfig& config) {
  GcodeSetting setting;
  PANELCAL_TRY(const auto table, top.read_table(kGcode, setting));
  if (!table) return {};
  PANELCAL_CHECK(check_heights(*table, setting));
  PANELCAL_CHECK(check_work(*table, setting.usual, setting));
  PANELCAL_TRY(const auto rows, table->tables(kGcodeTool));
  for (const TomlTable& row : rows) {
    PANELCAL_TRY(const GcodeTool tool, read_gcode_tool(row, setting));
    PANELCAL_CHECK(add_tool_row(row, tool, is_within_um, setting.tools));
  }
  config.gcode = setting;
  return {};
}

}  // namespace

Section gcode_section() {
  return {kGcodeTables, read_gcode};
}

}  // namespace panelcal::internal
