// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "calib/base/fields/slots.h"
#include "calib/ledger/entry/entry.h"
#include "machine/config/nightly/surface.h"
#include "machine/config/sections/sections.h"
#include "machine/config/toml/command_words.h"
#include "machine/config/toml/ranges.h"

namespace panelcal::internal {
namespace {

/// The kind of calibration with this name; null if there is none.
const CalibrationWords* calibration_named(std::string_view name) {
  const auto found = std::ranges::find(calibration_words(), name, &CalibrationWords::word);
  return found == calibration_words().end() ? nullptr : &*found;
}

constexpr Range kNights{20, 1e5};
/// Of all charts together: each of ten is within kNights then.
constexpr Range kNightsOfAll{20, 1e4};
constexpr Range kTemperature_c{-50, 100};
constexpr Range kTrialSeconds{1e-3, 3600};
constexpr int kMaxHoles = 1'000'000;

bool put_calibrations(NightlyConfig& config, const FieldValue& value) {
  config.calibrate = value.texts;
  return !value.texts.empty() && std::ranges::all_of(value.texts, [&](const std::string& kind) {
    return calibration_named(kind) != nullptr && std::ranges::count(value.texts, kind) == 1;
  });
}

bool put_driver(NightlyConfig& config, const FieldValue& value) {
  config.is_simulated = value.text == "sim";
  return config.is_simulated;
}

bool put_temperature_command(NightlyConfig& config, const FieldValue& value) {
  config.temperature_command = value.texts;
  const bool has_program = !value.texts.empty() && !value.texts.front().empty();
  if (!has_program || has_zero_byte(value.texts)) return false;
  look_for_program(config.temperature_command, value.folder);
  return true;
}

#include "machine/config/nightly/nightly.def"

Expected<void> check_night_mark(const TomlTable& table, NightlyConfig& config) {
  if (config.mark) config.mark_place = table.place_of("mark_mm");
  if (config.mark || !table.has("mark_tool")) return {};
  return failure(table.problem("mark_tool", "mark_mm as well", "there is no mark to find"));
}

Expected<void> check_warm_up(const TomlTable& table, const NightlyConfig& config) {
  if (!config.warm_up_limit) return {};
  if (!(config.warm_up > Time())) {
    return failure(table.problem("warm_up_limit_um", "warm_up_s as well, the longest it may take"));
  }
  if (config.mark) return {};
  return failure(
      table.problem("warm_up_limit_um", "mark_mm as well", "there is no mark to look at"));
}

Expected<void> check_night(const TomlTable& table, NightlyConfig& config) {
  if (config.is_simulated != config.camera.empty()) {
    return failure(
        table.missing("one way to the machine", "camera = \"URI\" or machine_driver = \"sim\""));
  }
  PANELCAL_CHECK(check_night_mark(table, config));
  if (table.has("temperature_file") && table.has("temperature_command")) {
    return failure(
        table.problem("temperature_command", "only one of the two", "there is temperature_file"));
  }
  return check_warm_up(table, config);
}

Expected<void> read_night_gates(const TomlTable& nightly, NightLimits& limits) {
  PANELCAL_TRY(const auto table, nightly.read_table(kNightGates, limits));
  if (!table || !limits.min_temperature_c) return {};
  if (*limits.min_temperature_c < *limits.max_temperature_c) return {};
  return failure(table->problem("temperature_c", "[lowest, highest]"));
}

Expected<void> read_trials(const TomlTable& nightly, NightTrials& trials) {
  PANELCAL_CHECK(nightly.read_table(kFocus, trials));
  PANELCAL_TRY(const auto light, nightly.read_table(kLight, trials));
  if (light && !(trials.lamp_low < trials.lamp_high)) {
    return failure(light->problem("range", "[lowest, highest] of the lamp's levels"));
  }
  PANELCAL_CHECK(nightly.read_table(kSettle, trials));
  return {};
}

Expected<void> read_night_table(const TomlTable& nightly, NightlyConfig& config) {
  PANELCAL_TRY(const auto table, nightly.read_table(kNightTable, config.table));
  const bool is_asked = std::ranges::find(config.calibrate, "table") != config.calibrate.end();
  if (table || !is_asked) return {};
  return failure(
      nightly.missing("the plate that the table is calibrated on", "[nightly.table] plate"));
}

/// The first of them that needs a mark to look at; empty if none does.
std::string_view needs_mark(const std::vector<std::string>& calibrate) {
  const auto found = std::ranges::find_if(
      calibrate, [](std::string_view kind) { return calibration_named(kind)->is_at_mark; });
  return found == calibrate.end() ? std::string_view() : std::string_view(*found);
}

Expected<void> read_nightly(const TomlTable& top, MachineConfig& machine) {
  NightlyConfig config;
  PANELCAL_TRY(const auto table, top.read_table(kNightly, config));
  if (!table) return {};
  config.place = table->missing("", "").place;
  for (std::filesystem::path* const path : {&config.reports, &config.temperature_file}) {
    if (!path->empty() && table->folder().empty()) *path = "." / *path;
  }
  PANELCAL_CHECK(check_night(*table, config));
  PANELCAL_CHECK(read_night_gates(*table, config.limits));
  PANELCAL_CHECK(table->read_table(kDrift, config));
  PANELCAL_CHECK(read_trials(*table, config.trials));
  PANELCAL_CHECK(read_night_table(*table, config));
  PANELCAL_CHECK(read_night_surface(*table, config));
  const std::string_view looks_at_it = needs_mark(config.calibrate);
  if (!looks_at_it.empty() && !config.mark) {
    const std::string what = looks_at_it == "settle" ? "settle time" : std::string(looks_at_it);
    return failure(
        table->missing("the mark that the " + what + " is calibrated on", "mark_mm = [x, y]"));
  }
  machine.nightly = std::move(config);
  return {};
}

}  // namespace

Section nightly_section() {
  return {kNightlyTables, read_nightly};
}

}  // namespace panelcal::internal
