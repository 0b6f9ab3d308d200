// SPDX-License-Identifier: Apache-2.0
#include "machine/config/sections/stage.h"

#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::internal {
namespace {

/// A program and its words; a program with a relative path lies beside machine.toml.
Expected<CommandWords> read_command(const TomlTable& table,
                                    std::string_view key,
                                    const std::vector<std::string>& placeholders,
                                    const std::filesystem::path& folder) {
  if (!table.has(key)) return CommandWords();
  PANELCAL_TRY(CommandWords words, table.texts(key));
  const std::string form = fmt::format("[\"PROGRAM\", \"{}\"]", fmt::join(placeholders, "\", \""));
  if (words.empty() || words.front().empty()) {
    return failure(table.problem(key, form, "there is no program"));
  }
  for (const std::string& word : words) {
    if (word.find('\0') != std::string::npos) {
      return failure(table.problem(key, form, "no word of a command holds a zero byte"));
    }
  }
  const std::string problem = placeholder_problem(words, placeholders);
  if (!problem.empty()) return failure(table.problem(key, form, problem));
  const std::filesystem::path program = words.front();
  if (program.has_parent_path() && program.is_relative())
    words.front() = (folder / program).string();
  return words;
}

}  // namespace

Expected<void> read_stage_config(const TomlTable& table, MachineConfig& config) {
  constexpr double kLongest_s = 3600;
  StageCommands& stage = config.stage;
  // A bare name would be looked for in PATH.
  std::filesystem::path folder = config.file.parent_path();
  if (folder.empty()) folder = ".";
  PANELCAL_TRY(stage.move, read_command(table, "stage_command", {"{x}", "{y}"}, folder));
  PANELCAL_TRY(stage.drill, read_command(table, "drill_command", {"{tool}"}, folder));
  PANELCAL_TRY(stage.lamp, read_command(table, "lamp_command", {"{lamp}"}, folder));
  PANELCAL_TRY(stage.zoom, read_command(table, "zoom_command", {"{zoom}"}, folder));
  PANELCAL_TRY(stage.focus, read_command(table, "focus_command", {"{z}"}, folder));
  PANELCAL_TRY(stage.probe, read_command(table, "probe_command", {"{x}", "{y}"}, folder));
  PANELCAL_TRY(
      const double limit_s,
      table.number_or("command_limit_s", {0, kLongest_s, true}, config.stage.limit.in_s()));
  stage.limit = seconds(limit_s);
  PANELCAL_TRY(const double settle_s, table.number_or("settle_s", {0, kLongest_s}, 0));
  config.settle = seconds(settle_s);
  return {};
}

}  // namespace panelcal::internal
