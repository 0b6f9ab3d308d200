// SPDX-License-Identifier: Apache-2.0
#include "machine/config/sections/program.h"

#include <algorithm>
#include <array>
#include <utility>

#include "calib/correction/tolerance.h"
#include "machine/config/toml/ranges.h"
#include "machine/config/toml/tool_row.h"
#include "program/geometry/dot_font.h"
#include "program/sieb_meyer/text/plain_text.h"
#include "program/walk/control_settings.h"
#include "surface/control/memory.h"

namespace panelcal::internal {
namespace {

using Words = std::string_view;

constexpr std::array<Words, 17> kProgramKeys = {"absolute_zero_mm",
                                                "arc_tolerance_um",
                                                "axis_version",
                                                "block_delete",
                                                "breakage_counter",
                                                "character_set",
                                                "digits",
                                                "module",
                                                "obeys_areas",
                                                "operator_id",
                                                "rates",
                                                "run",
                                                "search_path",
                                                "spindle",
                                                "units",
                                                "work_zero_mm",
                                                "zeros"};
constexpr std::array<Words, 7> kSurfaceKeys = {"average",
                                               "fill_gaps",
                                               "grid_hold_mm",
                                               "height_mm",
                                               "height_tolerance_um",
                                               "max_sigma_um",
                                               "tolerance_mm"};
constexpr std::array<Words, 3> kDepthKeys = {"depth_mm", "drill_mm", "number"};
constexpr std::array<Words, 4> kScalingKeys = {"about_mm", "enabled", "x", "y"};
constexpr std::array<Words, 6> kDiameterKeys = {
    "depth_offset_mm", "diameter_mm", "infeed_mm_s", "max_hits", "retract_mm_s", "speed_rpm"};

constexpr Range kProgramLength{.low = 0, .low_is_open = true};
/// Contours are cut no coarser than this, in um.
constexpr Range kTolerance{0, 1000, true};
/// A panel that shrinks or grows by a tenth is another panel.
constexpr Range kScale{0.9, 1.1};
/// No board is thicker, no drill wider.
constexpr Range kDepth{.low = 0, .high = 100, .low_is_open = true};
constexpr int kMaxHits = 1'000'000'000;
constexpr int kMaxCounter = 1'000'000'000;

Expected<void> read_character_set(const TomlTable& table, sieb_meyer::Settings& settings) {
  PANELCAL_TRY(const auto name, table.text("character_set"));
  if (!name) return {};
  const auto known = character_set_from_name(*name);
  if (!known) {
    return failure(
        table.problem("character_set", "\"3x5\", \"4x6\", \"5x7\", \"excellon\" or \"hitachi\""));
  }
  settings.characters = *known;
  return {};
}

/// Settings that a SIEB & MEYER control has besides the program: above all what M97 and M98 may
/// drill.
Expected<void> read_control(const TomlTable& table, sieb_meyer::Settings& settings) {
  PANELCAL_CHECK(read_character_set(table, settings));
  sieb_meyer::TextVariables& text = settings.text;
  PANELCAL_TRY(const auto module, table.text("module"));
  text.module = module.value_or("");
  PANELCAL_TRY(const auto spindle, table.integer("spindle", 1, sieb_meyer::kMaxSpindle));
  if (spindle) text.spindle = static_cast<int>(*spindle);
  PANELCAL_TRY(const auto run, table.integer("run", 0, kMaxCounter));
  if (run) text.run = static_cast<int>(*run);
  PANELCAL_TRY(const auto breakages, table.integer("breakage_counter", 0, kMaxCounter));
  if (breakages) text.breakage_counter = static_cast<int>(*breakages);
  PANELCAL_TRY(settings.obeys_areas, table.truth("obeys_areas"));
  return {};
}

template <class Part>
Expected<void> read_part(const TomlTable& table,
                         Words key,
                         const char* expected,
                         std::optional<Part> (*parse)(Words),
                         std::optional<Part>& part) {
  PANELCAL_TRY(const auto text, table.text(key));
  if (!text) return {};
  part = parse(*text);
  if (!part) return failure(table.problem(key, expected));
  return {};
}

/// The control's last setting, for programs that do not state their number format.
Expected<void> read_format(const TomlTable& table, PartialFormat& format) {
  PANELCAL_CHECK(read_part(table, "units", "\"inch\" or \"metric\"", parse_unit, format.unit));
  PANELCAL_CHECK(read_part(
      table, "zeros", "\"LZ\" or \"TZ\": those that are kept", parse_zeros, format.zeros));
  PANELCAL_CHECK(read_part(table, "digits", "digits such as \"2.4\"", parse_digits, format.digits));
  // Digits hold for one unit alone.
  if (format.digits && !format.unit) {
    return failure(table.problem("digits", "units as well, whose digits they are"));
  }
  if (!format.is_empty()) format.from = "[program] of machine.toml";
  return {};
}

Expected<void> read_program(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.table("program", "[program]", {kProgramKeys, {}}));
  if (!table) return {};
  PANELCAL_TRY(const auto work_mm, table->pair("work_zero_mm", kPlace));
  if (work_mm) config.walk.work_zero = position_mm<frame::Machine>(*work_mm);
  PANELCAL_TRY(const auto absolute_mm, table->pair("absolute_zero_mm", kPlace));
  if (absolute_mm) config.walk.absolute_zero = position_mm<frame::Machine>(*absolute_mm);
  PANELCAL_TRY(const auto tolerance_um, table->number("arc_tolerance_um", kTolerance));
  if (tolerance_um) config.walk.arc_tolerance = um(*tolerance_um);
  PANELCAL_TRY(const auto version, table->integer("axis_version", 1, 8));
  if (version) config.reading.axis_version = static_cast<int>(*version);
  PANELCAL_TRY(config.reading.block_delete, table->truth("block_delete"));
  PANELCAL_TRY(const auto operator_id, table->text("operator_id"));
  config.reading.operator_id = operator_id.value_or("");
  if (config.reading.operator_id.size() > 20) {
    return failure(table->problem("operator_id", "at most 20 characters (OPID)"));
  }
  config.walk.sieb_meyer.text.operator_text = config.reading.operator_id;
  PANELCAL_CHECK(read_format(*table, config.reading.last_format));
  PANELCAL_CHECK(read_part(
      *table, "rates", "\"inch/min\" or \"m/min\"", parse_rate_unit, config.reading.inch_rates));
  PANELCAL_CHECK(read_control(*table, config.walk.sieb_meyer));
  PANELCAL_TRY(const auto folders, table->texts("search_path"));
  for (const std::string& folder : folders) {
    config.reading.pattern_folders.push_back(config.file.parent_path() / folder);
  }
  return {};
}

Expected<void> read_average(const TomlTable& table, sieb_meyer::Settings& settings) {
  constexpr std::array<std::pair<Words, AverageKind>, 4> kAverages = {
      {{"A", AverageKind::Mean},
       {"M", AverageKind::Median},
       {"O", AverageKind::MidRange},
       {"T", AverageKind::TrimmedMean}}};
  PANELCAL_TRY(const auto letter, table.text("average"));
  if (!letter) return {};
  const auto known = std::ranges::find(kAverages, *letter, &std::pair<Words, AverageKind>::first);
  if (known == kAverages.end()) {
    return failure(table.problem("average", "\"A\", \"M\", \"O\" or \"T\", as SPAV has them"));
  }
  settings.average = known->second;
  return {};
}

Expected<void> read_surface(const TomlTable& top, WalkOptions& walk) {
  PANELCAL_TRY(const auto table, top.table("surface", "[surface]", {kSurfaceKeys, {}}));
  if (!table) return {};
  sieb_meyer::Settings& settings = walk.sieb_meyer;
  PANELCAL_CHECK(read_average(*table, settings));
  PANELCAL_TRY(const auto height_mm, table->number("height_mm", kPlace));
  if (height_mm) settings.surface_height = mm(*height_mm);
  PANELCAL_TRY(const auto tolerance_mm, table->number("tolerance_mm", kProgramLength));
  if (tolerance_mm) settings.surface_tolerance = mm(*tolerance_mm);
  PANELCAL_TRY(const auto hold_mm, table->number("grid_hold_mm", {0, kMaxPlace_mm}));
  if (hold_mm) settings.grid_hold = mm(*hold_mm);
  PANELCAL_TRY(const auto height_um, table->number("height_tolerance_um", kTolerance));
  if (height_um) walk.board.height_tolerance = um(*height_um);
  PANELCAL_TRY(const auto sigma_um, table->number("max_sigma_um", kProgramLength));
  if (sigma_um) walk.board.max_sigma = um(*sigma_um);
  PANELCAL_TRY(const auto fills, table->truth("fill_gaps"));
  settings.fills_gaps = fills.value_or(false);
  return {};
}

Expected<ToolDepth> read_tool_depth(const TomlTable& table) {
  PANELCAL_TRY(const internal::ToolRow tool, internal::read_single_tool_row(table));
  PANELCAL_TRY(const auto depth_mm, table.number("depth_mm", kDepth));
  if (!depth_mm) return failure(table.missing("depth_mm", "depth_mm = 0.8"));
  return ToolDepth{tool.number, tool.drill, mm(*depth_mm)};
}

/// Rows that would both be a tool's are refused: one of them is wrong.
Expected<void> read_depths(const TomlTable& top, BoardDepths& board) {
  PANELCAL_TRY(const auto rows, top.tables("depth", "[[depth]]", {kDepthKeys, {}}));
  for (const TomlTable& table : rows) {
    PANELCAL_TRY(const ToolDepth row, read_tool_depth(table));
    for (const ToolDepth& other : board.tools) {
      const bool is_same = row.number ? row.number == other.number
                                      : other.drill && is_same_drill(*row.drill, *other.drill);
      if (!is_same) continue;
      return failure(table.problem(
          row.number ? "number" : "drill_mm", "each tool once", "another row names it"));
    }
    board.tools.push_back(row);
  }
  return {};
}

Expected<void> read_scaling(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table,
               top.table("reference_scaling", "[reference_scaling]", {kScalingKeys, {}}));
  if (!table) return {};
  ReferenceScaling scaling;
  PANELCAL_TRY(scaling.x, table->number_or("x", kScale, 1));
  PANELCAL_TRY(scaling.y, table->number_or("y", kScale, 1));
  PANELCAL_TRY(const auto about_mm, table->pair("about_mm", kPlace));
  if (about_mm) scaling.about = position_mm<frame::Nominal>(*about_mm);
  PANELCAL_TRY(const auto enabled, table->truth("enabled"));
  scaling.starts_enabled = enabled.value_or(false);
  config.walk.scaling = scaling;
  return {};
}

Expected<Tool> read_diameter(const TomlTable& table) {
  Tool row;
  PANELCAL_TRY(const auto diameter_mm, table.number("diameter_mm", kProgramLength));
  if (!diameter_mm) return failure(table.missing("diameter_mm", "diameter_mm = 1.016"));
  row.diameter = mm(*diameter_mm);
  PANELCAL_TRY(const auto infeed, table.number("infeed_mm_s", kProgramLength));
  if (infeed) row.infeed = mm_per_s(*infeed);
  PANELCAL_TRY(const auto retract, table.number("retract_mm_s", kProgramLength));
  if (retract) row.retract = mm_per_s(*retract);
  PANELCAL_TRY(const auto speed, table.number("speed_rpm", kProgramLength));
  if (speed) row.speed = rpm(*speed);
  PANELCAL_TRY(const auto max_hits, table.integer("max_hits", 1, kMaxHits));
  if (max_hits) row.max_hits = static_cast<int>(*max_hits);
  PANELCAL_TRY(const auto depth_mm, table.number("depth_offset_mm", kPlace));
  if (depth_mm) row.depth_offset = mm(*depth_mm);
  return row;
}

}  // namespace

Expected<void> read_program_config(const TomlTable& top, MachineConfig& config) {
  PANELCAL_CHECK(read_program(top, config));
  PANELCAL_CHECK(read_surface(top, config.walk));
  PANELCAL_CHECK(read_depths(top, config.walk.board));
  PANELCAL_CHECK(read_scaling(top, config));
  PANELCAL_TRY(const auto rows,
               top.tables("diameter_page", "[[diameter_page]]", {kDiameterKeys, {}}));
  for (const TomlTable& table : rows) {
    PANELCAL_TRY(Tool row, read_diameter(table));
    for (const Tool& other : config.reading.diameter_page) {
      if (is_same_drill(*other.diameter, *row.diameter)) {
        return failure(table.problem(
            "diameter_mm", "each diameter once", "another row has it, within 0.5 um"));
      }
    }
    config.reading.diameter_page.push_back(row);
  }
  return {};
}

Expected<void> read_travel(const TomlTable& machine, MachineConfig& config) {
  PANELCAL_TRY(const auto low_mm, machine.pair("travel_low_mm", kPlace));
  PANELCAL_TRY(const auto high_mm, machine.pair("travel_high_mm", kPlace));
  if (!low_mm && !high_mm) return {};
  if (!low_mm || !high_mm) {
    return failure(
        machine.missing(low_mm ? "travel_high_mm" : "travel_low_mm", "both corners of the travel"));
  }
  if ((low_mm->array() >= high_mm->array()).any()) {
    return failure(machine.problem("travel_high_mm", "more than travel_low_mm in x and y"));
  }
  config.travel =
      Travel{position_mm<frame::Machine>(*low_mm), position_mm<frame::Machine>(*high_mm)};
  config.reading.travel_mm = *high_mm - *low_mm;
  return {};
}

}  // namespace panelcal::internal
