// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/fields/slots.h"
#include "machine/config/sections/sections.h"
#include "machine/config/toml/command_words.h"
#include "machine/config/toml/ranges.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::internal {
namespace {

constexpr double kLongestWait_s = 3600;

#include "machine/config/sections/stage.def"

struct StageCommand {
  std::string_view key;
  CommandWords StageCommands::*words;
  std::vector<std::string> placeholders;
};

/// A program and its words; a program with a relative path lies beside machine.toml.
Expected<void> check_command(const TomlTable& table,
                             const StageCommand& command,
                             const std::filesystem::path& folder,
                             StageCommands& stage) {
  if (!table.has(command.key)) return {};
  CommandWords& words = stage.*command.words;
  const std::string form =
      fmt::format("[\"PROGRAM\", \"{}\"]", fmt::join(command.placeholders, "\", \""));
  if (words.empty() || words.front().empty()) {
    return failure(table.problem(command.key, form, "there is no program"));
  }
  if (has_zero_byte(words)) {
    return failure(table.problem(command.key, form, "no word of a command holds a zero byte"));
  }
  const std::string problem = placeholder_problem(words, command.placeholders);
  if (!problem.empty()) return failure(table.problem(command.key, form, problem));
  look_for_program(words, folder);
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

Expected<void> read_machine(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.read_table(kMachine, config));
  if (!table) return {};
  for (const StageCommand& command :
       {StageCommand{"stage_command", &StageCommands::move, {"{x}", "{y}"}},
        StageCommand{"drill_command", &StageCommands::drill, {"{tool}"}},
        StageCommand{"lamp_command", &StageCommands::lamp, {"{lamp}"}},
        StageCommand{"zoom_command", &StageCommands::zoom, {"{zoom}"}},
        StageCommand{"focus_command", &StageCommands::focus, {"{z}"}},
        StageCommand{"probe_command", &StageCommands::probe, {"{x}", "{y}"}}}) {
    PANELCAL_CHECK(check_command(*table, command, config.file.parent_path(), config.stage));
  }
  return read_travel(*table, config);
}

}  // namespace

Section machine_section() {
  return {kStageTables, read_machine};
}

}  // namespace panelcal::internal
