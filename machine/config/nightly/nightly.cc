// SPDX-License-Identifier: Apache-2.0
#include "machine/config/nightly/nightly.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "machine/config/nightly/surface.h"
#include "machine/config/toml/ranges.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::array<std::string_view, 19> kNightlyKeys = {"calibrate",
                                                           "camera",
                                                           "drift",
                                                           "focus",
                                                           "gates",
                                                           "light",
                                                           "machine_driver",
                                                           "mark_mm",
                                                           "mark_tool",
                                                           "min_disk_mb",
                                                           "noon_utc_h",
                                                           "reports",
                                                           "settle",
                                                           "surface",
                                                           "table",
                                                           "temperature_command",
                                                           "temperature_file",
                                                           "warm_up_limit_um",
                                                           "warm_up_s"};
constexpr std::array<std::string_view, 7> kNightGateKeys = {"change_um",
                                                            "max_outliers",
                                                            "min_holes",
                                                            "nights_per_refusal",
                                                            "sigma_um",
                                                            "structure_chance",
                                                            "temperature_c"};
constexpr std::array<std::string_view, 12> kDriftKeys = {"drift_um",
                                                         "expected_c",
                                                         "horizon_days",
                                                         "min_nights",
                                                         "moved_um",
                                                         "nights_per_false_alarm",
                                                         "per_kelvin_um",
                                                         "probability",
                                                         "reference_c",
                                                         "repeatability_um",
                                                         "tolerance_um",
                                                         "trusted_days"};
constexpr std::array<std::string_view, 1> kFocusKeys = {"tolerance_um"};
constexpr std::array<std::string_view, 2> kLightKeys = {"levels", "range"};
constexpr std::array<std::string_view, 3> kSettleKeys = {"limit_um", "longest_s", "tolerance_s"};
constexpr std::array<std::string_view, 2> kNightTableKeys = {"file", "plate"};
constexpr std::array<std::string_view, 7> kCalibrations = {
    "camera", "focus", "light", "settle", "spindle-camera", "surface", "table"};
constexpr std::string_view kCalibrationWords =
    "\"camera\", \"focus\", \"light\", \"settle\", \"spindle-camera\", \"surface\", "
    "\"table\", each once";

constexpr Range kNights{20, 1e5};
/// Of all charts together: each of ten is within kNights then.
constexpr Range kNightsOfAll{20, 1e4};
constexpr Range kTemperature_c{-50, 100};
constexpr double kMostSeconds = 86400;
constexpr int kMaxHoles = 1'000'000;
constexpr Range kLampLevel{0, 1e6};
constexpr Range kTrialSeconds{1e-3, 3600};

Expected<void> read_what(const TomlTable& table, NightlyConfig& config) {
  if (table.has("calibrate")) {
    PANELCAL_TRY(config.calibrate, table.texts("calibrate"));
    for (const std::string& kind : config.calibrate) {
      const bool is_known = std::ranges::find(kCalibrations, kind) != kCalibrations.end();
      if (!is_known || std::ranges::count(config.calibrate, kind) > 1) {
        return failure(table.problem("calibrate", std::string(kCalibrationWords)));
      }
    }
    if (config.calibrate.empty()) {
      return failure(table.problem("calibrate", std::string(kCalibrationWords)));
    }
  }
  PANELCAL_TRY(const auto driver, table.text("machine_driver"));
  if (driver && *driver != "sim") return failure(table.problem("machine_driver", "\"sim\""));
  config.is_simulated = driver.has_value();
  PANELCAL_TRY(const auto camera, table.text("camera"));
  config.camera = camera.value_or("");
  if (config.is_simulated != config.camera.empty()) {
    return failure(
        table.missing("one way to the machine", "camera = \"URI\" or machine_driver = \"sim\""));
  }
  return {};
}

Expected<void> read_mark(const TomlTable& table, NightlyConfig& config) {
  PANELCAL_TRY(const auto mark_mm, table.pair("mark_mm", kPlace));
  if (mark_mm) {
    config.mark = position_mm<frame::Machine>(*mark_mm);
    config.mark_place = table.problem("mark_mm", "").place;
  }
  PANELCAL_TRY(const auto tool, table.integer("mark_tool", 1, kMaxToolNumber));
  if (tool && !mark_mm) {
    return failure(table.problem("mark_tool", "mark_mm as well", "there is no mark to find"));
  }
  if (tool) config.mark_tool = static_cast<int>(*tool);
  return {};
}

Expected<void> read_surroundings(const TomlTable& table,
                                 std::filesystem::path folder,
                                 NightlyConfig& config) {
  // A bare name would be looked for in PATH.
  if (folder.empty()) folder = ".";
  PANELCAL_TRY(const auto reports, table.text("reports"));
  if (reports && reports->empty()) return failure(table.problem("reports", "the name of a folder"));
  if (reports) config.reports = folder / *reports;
  PANELCAL_TRY(const auto file, table.text("temperature_file"));
  if (file && file->empty()) {
    return failure(table.problem("temperature_file", "the name of a file"));
  }
  if (file) config.temperature_file = folder / *file;
  if (!table.has("temperature_command")) return {};
  if (file) {
    return failure(
        table.problem("temperature_command", "only one of the two", "there is temperature_file"));
  }
  PANELCAL_TRY(config.temperature_command, table.texts("temperature_command"));
  std::vector<std::string>& words = config.temperature_command;
  const bool is_broken = std::ranges::any_of(
      words, [](const std::string& word) { return word.find('\0') != std::string::npos; });
  if (words.empty() || words.front().empty() || is_broken) {
    return failure(table.problem("temperature_command", "[\"PROGRAM\", \"WORD\", ...]"));
  }
  const std::filesystem::path program = words.front();
  if (program.has_parent_path() && program.is_relative()) {
    words.front() = (folder / program).string();
  }
  return {};
}

Expected<void> read_warm_up(const TomlTable& table, NightlyConfig& config) {
  PANELCAL_TRY(const double warm_up_s, table.number_or("warm_up_s", {0, kMostSeconds}, 0));
  config.warm_up = seconds(warm_up_s);
  PANELCAL_TRY(const auto limit_um, table.number("warm_up_limit_um", kAboveZero_um));
  if (!limit_um) return {};
  if (!(config.warm_up > Time())) {
    return failure(table.problem("warm_up_limit_um", "warm_up_s as well, the longest it may take"));
  }
  if (!config.mark) {
    return failure(
        table.problem("warm_up_limit_um", "mark_mm as well", "there is no mark to look at"));
  }
  config.warm_up_limit = um(*limit_um);
  return {};
}

Expected<void> read_night_gates(const TomlTable& nightly, NightLimits& limits) {
  PANELCAL_TRY(const auto table, nightly.table("gates", "[nightly.gates]", {kNightGateKeys, {}}));
  if (!table) return {};
  PANELCAL_CHECK(read_um_in_mm(*table, "sigma_um", limits.sigma));
  PANELCAL_CHECK(read_um_in_mm(*table, "change_um", limits.change));
  PANELCAL_TRY(const auto holes, table->integer("min_holes", 1, kMaxHoles));
  if (holes) limits.min_used = static_cast<int>(*holes);
  PANELCAL_TRY(const auto outliers, table->integer("max_outliers", 0, kMaxHoles));
  if (outliers) limits.max_outliers = static_cast<int>(*outliers);
  PANELCAL_TRY(limits.structure_chance,
               table->number_or("structure_chance", {0, 0.5}, limits.structure_chance));
  PANELCAL_TRY(limits.nights_per_refusal,
               table->number_or("nights_per_refusal", kNights, limits.nights_per_refusal));
  PANELCAL_TRY(const auto range, table->pair("temperature_c", kTemperature_c));
  if (!range) return {};
  if (!(range->x() < range->y())) {
    return failure(table->problem("temperature_c", "[lowest, highest]"));
  }
  limits.min_temperature_c = range->x();
  limits.max_temperature_c = range->y();
  return {};
}

Expected<void> read_drift(const TomlTable& nightly, NightlyConfig& config) {
  PANELCAL_TRY(const auto table, nightly.table("drift", "[nightly.drift]", {kDriftKeys, {}}));
  if (!table) return {};
  ForecastLimits& old = config.limits.old;
  PANELCAL_CHECK(read_um_in_mm(*table, "tolerance_um", old.tolerance));
  PANELCAL_TRY(old.probability, table->number_or("probability", {1e-6, 0.4}, old.probability));
  constexpr double kDay_s = 86400;
  PANELCAL_TRY(const double days,
               table->number_or("horizon_days", {1, 1000}, old.horizon.in_s() / kDay_s));
  old.horizon = seconds(days * kDay_s);
  PANELCAL_TRY(const double trusted_days,
               table->number_or("trusted_days", {1, 1000}, old.trusted.in_s() / kDay_s));
  old.trusted = seconds(trusted_days * kDay_s);
  PANELCAL_TRY(old.temperature_c, table->number("expected_c", kTemperature_c));
  DriftOptions& drift = config.drift;
  PANELCAL_CHECK(read_um_in_mm(*table, "drift_um", drift.priors.drift));
  PANELCAL_CHECK(read_um_in_mm(*table, "repeatability_um", drift.priors.repeatability));
  PANELCAL_CHECK(read_um_in_mm(*table, "per_kelvin_um", drift.priors.per_kelvin));
  PANELCAL_TRY(drift.reference_c,
               table->number_or("reference_c", kTemperature_c, drift.reference_c));
  PANELCAL_TRY(const auto nights, table->integer("min_nights", 5, 1000));
  if (nights) drift.min_nights = static_cast<int>(*nights);
  PANELCAL_TRY(config.watch.nights_per_false_alarm,
               table->number_or(
                   "nights_per_false_alarm", kNightsOfAll, config.watch.nights_per_false_alarm));
  return read_um_in_mm(*table, "moved_um", *config.watch.moved);
}

Expected<void> read_focus_trial(const TomlTable& nightly, NightTrials& trials) {
  PANELCAL_TRY(const auto table, nightly.table("focus", "[nightly.focus]", {kFocusKeys, {}}));
  if (!table) return {};
  double tolerance_mm = trials.focus_tolerance.in_mm();
  PANELCAL_CHECK(read_um_in_mm(*table, "tolerance_um", tolerance_mm));
  trials.focus_tolerance = mm(tolerance_mm);
  return {};
}

Expected<void> read_light_trial(const TomlTable& nightly, NightTrials& trials) {
  PANELCAL_TRY(const auto table, nightly.table("light", "[nightly.light]", {kLightKeys, {}}));
  if (!table) return {};
  PANELCAL_TRY(const auto range, table->pair("range", kLampLevel));
  if (range && !(range->x() < range->y())) {
    return failure(table->problem("range", "[lowest, highest] of the lamp's levels"));
  }
  if (range) trials.lamp_low = range->x();
  if (range) trials.lamp_high = range->y();
  PANELCAL_TRY(const auto levels, table->integer("levels", 3, 1000));
  if (levels) trials.n_lamp_levels = static_cast<int>(*levels);
  return {};
}

Expected<void> read_settle_trial(const TomlTable& nightly, NightTrials& trials) {
  PANELCAL_TRY(const auto table, nightly.table("settle", "[nightly.settle]", {kSettleKeys, {}}));
  if (!table) return {};
  double limit_mm = trials.settle_limit.in_mm();
  PANELCAL_CHECK(read_um_in_mm(*table, "limit_um", limit_mm));
  trials.settle_limit = mm(limit_mm);
  PANELCAL_TRY(const double longest_s,
               table->number_or("longest_s", kTrialSeconds, trials.settle_longest.in_s()));
  trials.settle_longest = seconds(longest_s);
  PANELCAL_TRY(const double tolerance_s,
               table->number_or("tolerance_s", kTrialSeconds, trials.settle_tolerance.in_s()));
  trials.settle_tolerance = seconds(tolerance_s);
  return {};
}

/// In     folder: where machine.toml is
Expected<void> read_night_table(const TomlTable& nightly,
                                const std::filesystem::path& folder,
                                NightlyConfig& config) {
  const bool is_asked = std::ranges::find(config.calibrate, "table") != config.calibrate.end();
  PANELCAL_TRY(const auto table, nightly.table("table", "[nightly.table]", {kNightTableKeys, {}}));
  if (!table && !is_asked) return {};
  if (!table) {
    return failure(
        nightly.missing("the plate that the table is calibrated on", "[nightly.table] plate"));
  }
  PANELCAL_TRY(const auto plate, table->text("plate"));
  if (!plate || plate->empty()) return failure(table->missing("plate", "plate = \"NAME\""));
  config.table.plate = folder / *plate;
  PANELCAL_TRY(const auto file, table->text("file"));
  if (file && !file->empty()) config.table.file = folder / *file;
  return {};
}

/// The first of them that needs a mark to look at; empty if none does.
std::string_view needs_mark(const std::vector<std::string>& calibrate) {
  const auto found = std::ranges::find_if(calibrate, [](std::string_view kind) {
    return kind != "spindle-camera" && kind != "table" && kind != "surface";
  });
  return found == calibrate.end() ? std::string_view() : std::string_view(*found);
}

}  // namespace

Expected<std::optional<NightlyConfig>> read_nightly_config(const TomlTable& top,
                                                           const std::filesystem::path& folder) {
  std::optional<NightlyConfig> none;
  PANELCAL_TRY(const auto table, top.table("nightly", "[nightly]", {kNightlyKeys, {}}));
  if (!table) return none;
  NightlyConfig config;
  config.place = table->missing("", "").place;
  PANELCAL_CHECK(read_what(*table, config));
  PANELCAL_CHECK(read_mark(*table, config));
  PANELCAL_CHECK(read_surroundings(*table, folder, config));
  PANELCAL_CHECK(read_warm_up(*table, config));
  PANELCAL_TRY(config.min_disk_mb, table->number_or("min_disk_mb", {0, 1e9}, config.min_disk_mb));
  PANELCAL_TRY(const auto noon, table->integer("noon_utc_h", 0, 23));
  if (noon) config.noon_utc_h = static_cast<int>(*noon);
  PANELCAL_CHECK(read_night_gates(*table, config.limits));
  PANELCAL_CHECK(read_drift(*table, config));
  PANELCAL_CHECK(read_focus_trial(*table, config.trials));
  PANELCAL_CHECK(read_light_trial(*table, config.trials));
  PANELCAL_CHECK(read_settle_trial(*table, config.trials));
  PANELCAL_CHECK(read_night_table(*table, folder, config));
  PANELCAL_CHECK(read_night_surface(*table, folder, config));
  const std::string_view looks_at_it = needs_mark(config.calibrate);
  if (!looks_at_it.empty() && !config.mark) {
    const std::string what = looks_at_it == "settle" ? "settle time" : std::string(looks_at_it);
    return failure(
        table->missing("the mark that the " + what + " is calibrated on", "mark_mm = [x, y]"));
  }
  return std::optional(std::move(config));
}

}  // namespace panelcal::internal
