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

// control.def first: stage.def joins it.
#include "machine/config/sections/control.def"
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

/// All four keys of the probe, or none.
Expected<void> read_probe(const TomlTable& machine, ControlSetting& control) {
  constexpr std::array<std::string_view, 4> kKeys = {
      "probe_feed_mm_min", "probe_from_mm", "probe_to_mm", "probe_z0_mm"};
  std::array<double, 4> values{};
  std::string_view stated, absent;
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    PANELCAL_TRY(const auto value, machine.number(kKeys[i], i == 0 ? kMachineFeed_mm_min : kPlace));
    (value ? stated : absent) = kKeys[i];
    values[i] = value.value_or(0);
  }
  if (stated.empty()) return {};
  if (!absent.empty()) {
    return failure(machine.missing(absent, fmt::format("{} to probe", fmt::join(kKeys, ", "))));
  }
  control.probe = ControlProbe{values[0], mm(values[1]), mm(values[2]), mm(values[3])};
  if (control.probe->to >= control.probe->from) {
    return failure(machine.problem("probe_to_mm", "less than probe_from_mm"));
  }
  if (control.probe->from > control.safe_z) {
    return failure(machine.problem("probe_from_mm", "at most safe_z_mm"));
  }
  return {};
}

Expected<void> read_control(const TomlTable& machine, ControlSetting& control) {
  if (!control.driver) {
    for (const Field& field : kControlFields) {
      if (!machine.has(field.key)) continue;
      return failure(machine.problem(
          field.key, "driver = \"grbl\" or \"linuxcnc\"", "it is of a machine with a driver"));
    }
    return {};
  }
  for (const std::string_view other : {"stage_command", "probe_command"}) {
    if (!machine.has(other)) continue;
    return failure(machine.problem(other, "driver or " + std::string(other), "there is a driver"));
  }
  if (!machine.has("safe_z_mm")) {
    return failure(machine.missing("safe_z_mm", "safe_z_mm = Z where X and Y may move"));
  }
  const bool is_grbl = *control.driver == ControlKind::Grbl;
  for (const std::string_view key : {"connect_password", "enable_password"}) {
    if (is_grbl && machine.has(key)) {
      return failure(machine.problem(key, "no such key", "it is of linuxcncrsh"));
    }
  }
  if (!is_grbl && machine.has("device")) {
    return failure(machine.problem("device", "host", "LinuxCNC is in the network"));
  }
  if (is_grbl && control.device.empty() == control.host.empty()) {
    return failure(machine.problem("driver", "either device or host"));
  }
  for (const auto& [key, other] : {std::pair("port", "device"), std::pair("baud", "host")}) {
    if (is_grbl && machine.has(key) && machine.has(other)) {
      return failure(
          machine.problem(key, "no such key", std::string("it does not go with ") + other));
    }
  }
  return read_probe(machine, control);
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
  PANELCAL_CHECK(read_control(*table, config.control));
  return read_travel(*table, config);
}

}  // namespace

Section machine_section() {
  return {kStageTables, read_machine};
}

}  // namespace panelcal::internal
