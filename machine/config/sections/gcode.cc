// SPDX-License-Identifier: Apache-2.0
#include "machine/config/sections/gcode.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "machine/config/toml/ranges.h"
#include "machine/config/toml/tool_row.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using Words = std::string_view;

constexpr std::array<Words, 15> kGcodeKeys = {"approach_z_mm",
                                              "board_z_mm",
                                              "change_z_mm",
                                              "drill_z_mm",
                                              "feed_mm_s",
                                              "infeed_mm_s",
                                              "length_offset",
                                              "peck_mm",
                                              "retract_mm_s",
                                              "rout_z_mm",
                                              "safe_z_mm",
                                              "speed_rpm",
                                              "spin_up_s",
                                              "table_z_mm",
                                              "tool"};
constexpr std::array<Words, 9> kGcodeToolKeys = {"drill_mm",
                                                 "drill_z_mm",
                                                 "feed_mm_s",
                                                 "infeed_mm_s",
                                                 "number",
                                                 "peck_mm",
                                                 "retract_mm_s",
                                                 "rout_z_mm",
                                                 "speed_rpm"};

constexpr Range kHeight_mm{-kMaxPlace_mm, kMaxPlace_mm};
constexpr Range kGcodeLength_mm{.low = 0, .high = kMaxPlace_mm, .low_is_open = true};
/// A feed that rounds to 0 in a program's digits would be no feed at all.
constexpr Range kRate_mm_s{1e-3, 1e5};
constexpr Range kSpeed_rpm{1, 1e7};
constexpr Range kWait_s{0, 3600};

Expected<std::optional<Length>> read_gcode_length(const TomlTable& table,
                                                  Words key,
                                                  const Range& range) {
  PANELCAL_TRY(const auto value_mm, table.number(key, range));
  return value_mm ? std::optional(mm(*value_mm)) : std::nullopt;
}

Expected<std::optional<Feed>> read_rate(const TomlTable& table, Words key) {
  PANELCAL_TRY(const auto value_mm_s, table.number(key, kRate_mm_s));
  return value_mm_s ? std::optional(mm_per_s(*value_mm_s)) : std::nullopt;
}

Expected<GcodeWork> read_work(const TomlTable& table) {
  GcodeWork work;
  PANELCAL_TRY(work.drill_z, read_gcode_length(table, "drill_z_mm", kHeight_mm));
  PANELCAL_TRY(work.rout_z, read_gcode_length(table, "rout_z_mm", kHeight_mm));
  PANELCAL_TRY(work.peck, read_gcode_length(table, "peck_mm", kGcodeLength_mm));
  PANELCAL_TRY(work.infeed, read_rate(table, "infeed_mm_s"));
  PANELCAL_TRY(work.retract, read_rate(table, "retract_mm_s"));
  PANELCAL_TRY(work.feed, read_rate(table, "feed_mm_s"));
  PANELCAL_TRY(const auto speed_rpm, table.number("speed_rpm", kSpeed_rpm));
  if (speed_rpm) work.speed = rpm(*speed_rpm);
  return work;
}

/// A height that the tool works at, or that lies in its way, has to be below where it moves
/// rapidly.
Expected<void> check_below(const TomlTable& table,
                           Words key,
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

Expected<void> read_heights(const TomlTable& table, GcodeSetting& setting) {
  PANELCAL_TRY(const auto safe_z, read_gcode_length(table, "safe_z_mm", kHeight_mm));
  if (!safe_z) {
    return failure(
        table.missing("safe_z_mm", "safe_z_mm = 5, a height for moves above everything"));
  }
  setting.safe_z = *safe_z;
  PANELCAL_TRY(setting.approach_z, read_gcode_length(table, "approach_z_mm", kHeight_mm));
  if (setting.approach_z && *setting.approach_z > setting.safe_z) {
    return failure(table.problem("approach_z_mm", "at most safe_z_mm"));
  }
  PANELCAL_TRY(setting.change_z, read_gcode_length(table, "change_z_mm", kHeight_mm));
  if (setting.change_z && *setting.change_z < setting.safe_z) {
    return failure(table.problem("change_z_mm", "at least safe_z_mm"));
  }
  PANELCAL_TRY(setting.table_z, read_gcode_length(table, "table_z_mm", kHeight_mm));
  PANELCAL_CHECK(check_below(table, "table_z_mm", setting.table_z, setting));
  PANELCAL_TRY(setting.board_z, read_gcode_length(table, "board_z_mm", kHeight_mm));
  return check_below(table, "board_z_mm", setting.board_z, setting);
}

Expected<GcodeTool> read_gcode_tool(const TomlTable& table, const GcodeSetting& setting) {
  GcodeTool row;
  PANELCAL_TRY(const ToolRow tool, read_single_tool_row(table));
  row.number = tool.number;
  row.drill = tool.drill;
  PANELCAL_TRY(row.work, read_work(table));
  if (row.work == GcodeWork()) {
    return failure(table.missing("drill_z_mm", "drill_z_mm, infeed_mm_s or another of [gcode]"));
  }
  PANELCAL_CHECK(check_work(table, row.work, setting));
  return row;
}

bool is_same_gcode_tool(const GcodeTool& a, const GcodeTool& b) {
  if (a.number || b.number) return a.number == b.number;
  return std::abs((*a.drill - *b.drill).in_um()) <= 1;
}

}  // namespace

Expected<std::optional<GcodeSetting>> read_gcode_config(const TomlTable& top) {
  PANELCAL_TRY(const auto table, top.table("gcode", "[gcode]", {kGcodeKeys, {}}));
  if (!table) return std::nullopt;
  GcodeSetting setting;
  PANELCAL_CHECK(read_heights(*table, setting));
  PANELCAL_TRY(const auto spin_up_s, table->number("spin_up_s", kWait_s));
  if (spin_up_s) setting.spin_up = seconds(*spin_up_s);
  PANELCAL_TRY(const auto has_length_offset, table->truth("length_offset"));
  setting.has_length_offset = has_length_offset.value_or(false);
  PANELCAL_TRY(setting.usual, read_work(*table));
  PANELCAL_CHECK(check_work(*table, setting.usual, setting));
  PANELCAL_TRY(const auto rows, table->tables("tool", "[[gcode.tool]]", {kGcodeToolKeys, {}}));
  for (const TomlTable& row : rows) {
    PANELCAL_TRY(const GcodeTool tool, read_gcode_tool(row, setting));
    const auto same = [&](const GcodeTool& other) { return is_same_gcode_tool(tool, other); };
    if (std::ranges::any_of(setting.tools, same)) {
      return failure(row.problem(
          tool.number ? "number" : "drill_mm", "each tool once", "another row names it"));
    }
    setting.tools.push_back(tool);
  }
  return setting;
}

}  // namespace panelcal::internal
