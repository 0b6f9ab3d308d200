// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string_view>

#include "calib/correction/tolerance.h"
#include "machine/config/sections/sections.h"
#include "machine/config/toml/tool_row.h"
#include "program/geometry/dot_font.h"
#include "program/walk/control_settings.h"
#include "surface/control/memory.h"

namespace panelcal::internal {
namespace {

constexpr Range kPositive{.low = 0, .low_is_open = true};
/// Contours are cut no coarser than this, in um.
constexpr Range kTolerance_um{0, 1000, true};
constexpr int kMaxCounter = 1'000'000'000;

std::optional<AverageKind> average_from_letter(std::string_view letter) {
  if (letter == "A") return AverageKind::Mean;
  if (letter == "M") return AverageKind::Median;
  if (letter == "O") return AverageKind::MidRange;
  if (letter == "T") return AverageKind::TrimmedMean;
  return std::nullopt;
}

bool put_operator(MachineConfig& config, const FieldValue& value) {
  config.reading.operator_id = value.text;
  config.walk.sieb_meyer.text.operator_text = value.text;
  return value.text.size() <= 20;
}

// A panel that shrinks or grows by a tenth is another panel.
constexpr Range kScale{0.9, 1.1};
#include "machine/config/sections/program.def"

Expected<void> read_program(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.read_table(kProgram, config));
  if (!table) return {};
  PartialFormat& format = config.reading.last_format;
  // Digits hold for one unit alone.
  if (format.digits && !format.unit) {
    return failure(table->problem("digits", "units as well, whose digits they are"));
  }
  if (!format.is_empty()) format.from = "[program] of machine.toml";
  return {};
}

/// Rows that would both be a tool's are refused: one of them is wrong.
Expected<void> read_depths(const TomlTable& top, BoardDepths& board) {
  PANELCAL_TRY(const auto rows, top.tables(kDepth));
  for (const TomlTable& table : rows) {
    ToolDepth row;
    PANELCAL_CHECK(table.read(kDepth, row));
    PANELCAL_CHECK(check_names_one_tool(table));
    PANELCAL_CHECK(add_tool_row(table, row, is_same_drill, board.tools));
  }
  return {};
}

Expected<void> read_diameters(const TomlTable& top, std::vector<Tool>& page) {
  PANELCAL_TRY(const auto rows, top.tables(kDiameter));
  for (const TomlTable& table : rows) {
    Tool row;
    PANELCAL_CHECK(table.read(kDiameter, row));
    for (const Tool& other : page) {
      if (is_same_drill(*other.diameter, *row.diameter)) {
        return failure(table.problem(
            "diameter_mm", "each diameter once", "another row has it, within 0.5 um"));
      }
    }
    page.push_back(row);
  }
  return {};
}

Expected<void> read_program_tables(const TomlTable& top, MachineConfig& config) {
  PANELCAL_CHECK(read_program(top, config));
  PANELCAL_CHECK(top.read_table(kSurface, config.walk));
  PANELCAL_CHECK(read_depths(top, config.walk.board));
  ReferenceScaling scaling;
  PANELCAL_TRY(const auto table, top.read_table(kScaling, scaling));
  if (table) config.walk.scaling = scaling;
  return read_diameters(top, config.reading.diameter_page);
}

}  // namespace

Section program_section() {
  return {kProgramTables, read_program_tables};
}

}  // namespace panelcal::internal
