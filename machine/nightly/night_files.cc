// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/nightly/night_files.h"

#include <cstdint>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/calib/calibration_file.h"
#include "panelcal/calib/ledger.h"
#include "panelcal/machine/calibration_record.h"
#include "panelcal/machine/camera_run.h"
#include "panelcal/machine/machine_config.h"
#include "panelcal/machine/toml_table.h"

namespace panelcal {
namespace {

using std::filesystem::path;

std::string why(const path& file, const Diagnostic& problem) {
  return fmt::format("{} could not be read ({}): written again from the ledger",
                     quoted(file.string(), 200),
                     problem.what);
}

/// Empty if there was nothing to do.
Expected<std::string> restore_camera(const MachineConfig& config, const Ledger& ledger) {
  const auto present = read_camera_calibration(config.camera_file);
  if (present) return std::string();
  PANELCAL_TRY(const auto in_force, ledger.in_force(camera_key(config, std::nullopt)));
  if (!in_force) return std::string();
  PANELCAL_TRY(const std::string text, ledger.result(in_force->id));
  PANELCAL_CHECK(parse_camera_calibration(text, fmt::format("ledger entry {}", in_force->id)));
  PANELCAL_CHECK(write_file(config.camera_file, text));
  return why(config.camera_file, present.error());
}

Expected<std::string> restore_spindle(const MachineConfig& config, const Ledger& ledger) {
  const auto present = read_spindle_calibration(config.spindle_setting.file);
  if (present) return std::string();
  PANELCAL_TRY(const bool is_written, install_spindle_camera(config, ledger));
  return is_written ? why(config.spindle_setting.file, present.error()) : std::string();
}

}  // namespace

Expected<NightFiles> find_night_files(const path& machine_toml) {
  PANELCAL_TRY(const std::string text, read_file(machine_toml, kMaxConfigBytes));
  PANELCAL_TRY(const toml::table document,
               internal::parse_toml({machine_toml.string(), std::string_view(text)}));
  const auto text_of = [&](std::string_view table, std::string_view key) {
    return document[table][key].value<std::string>().value_or("");
  };
  const auto file_of = [&](std::string_view table, std::string_view key) {
    const std::string name = text_of(table, key);
    return name.empty() ? path() : machine_toml.parent_path() / name;
  };
  NightFiles files;
  files.machine = text_of("machine", "name");
  files.ledger = file_of("ledger", "file");
  files.reports = file_of("nightly", "reports");
  files.camera = file_of("camera", "calibration");
  files.spindle = file_of("spindle", "calibration");
  const auto noon = document["nightly"]["noon_utc_h"].value<std::int64_t>();
  if (noon && *noon >= 0 && *noon <= 23) files.noon_utc_h = static_cast<int>(*noon);
  return files;
}

Expected<std::vector<std::string>> restore_damaged_files(const NightFiles& files) {
  std::vector<std::string> done;
  std::error_code ignored;
  if (files.ledger.empty() || !std::filesystem::exists(files.ledger, ignored)) return done;
  PANELCAL_TRY(const Ledger ledger, Ledger::open_to_read(files.ledger));
  PANELCAL_CHECK(ledger.verify());
  MachineConfig config;
  config.name = files.machine;
  config.camera_file = files.camera;
  config.spindle_setting.file = files.spindle;
  if (!files.camera.empty()) {
    PANELCAL_TRY(std::string line, restore_camera(config, ledger));
    if (!line.empty()) done.push_back(std::move(line));
  }
  if (!files.spindle.empty()) {
    PANELCAL_TRY(std::string line, restore_spindle(config, ledger));
    if (!line.empty()) done.push_back(std::move(line));
  }
  return done;
}

}  // namespace panelcal
