// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/record/night_files.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/camera/calibration/calibration_file.h"
#include "calib/ledger/ledger.h"
#include "calib/table/calibration_file.h"
#include "machine/calibrate/calibration_record.h"
#include "machine/calibrate/camera/run.h"
#include "machine/calibrate/table/run.h"
#include "machine/config/machine_config.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/config/toml/toml_table.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using std::filesystem::path;

std::string why(const path& file, const Diagnostic& problem) {
  return fmt::format("{} could not be read ({}): written again from the ledger",
                     quoted(file.string(), 200),
                     problem.message());
}

/// A file that is its entry's result, byte for byte. Empty if there was nothing to do.
///
/// In     parse: of bytes, and what messages call them
template <class Parse>
Expected<std::string> restore(const path& file,
                              const LedgerKey& key,
                              std::size_t most_bytes,
                              const Parse& parse,
                              const Ledger& ledger) {
  const Expected<std::string> bytes = read_file(file, most_bytes);
  Expected<void> present;
  if (!bytes) {
    present = failure(bytes.error());
  } else if (const auto parsed = parse(*bytes, file.string()); !parsed) {
    present = failure(parsed.error());
  }
  if (present) return std::string();
  PANELCAL_TRY(const auto in_force, ledger.in_force(key));
  if (!in_force) return std::string();
  PANELCAL_TRY(const std::string text, ledger.result(in_force->id));
  PANELCAL_CHECK(parse(text, fmt::format("ledger entry {}", in_force->id)));
  PANELCAL_CHECK(write_file(file, text));
  return why(file, present.error());
}

Expected<std::string> restore_camera(const MachineConfig& config,
                                     const std::optional<double>& zoom,
                                     const path& file,
                                     const Ledger& ledger) {
  return restore(
      file, camera_key(config, zoom), kMaxCalibrationBytes, parse_camera_calibration, ledger);
}

Expected<std::string> restore_spindle(const MachineConfig& config, const Ledger& ledger) {
  const auto present = read_spindle_calibration(config.spindle_setting.file);
  if (present) return std::string();
  PANELCAL_TRY(const bool is_written, install_spindle_camera(config, ledger));
  return is_written ? why(config.spindle_setting.file, present.error()) : std::string();
}

}  // namespace

bool NightFiles::has_calibration(const path& file) const {
  const auto is_it = [&](const auto& zoom) { return zoom.second == file; };
  return !file.empty() &&
         (file == camera || file == spindle || file == table || std::ranges::any_of(zooms, is_it));
}

std::vector<path> NightFiles::that_note_the_head() const {
  std::vector<path> all = {camera, spindle, table, night_table, surface, reports};
  for (const auto& [level, file] : zooms) all.push_back(file);
  std::erase(all, path());
  std::ranges::sort(all);
  all.erase(std::ranges::unique(all).begin(), all.end());
  return all;
}

NightFiles night_files_of(const MachineConfig& config, const NightlyConfig& nightly) {
  NightFiles files;
  files.machine = config.name;
  files.ledger = config.ledger_file;
  files.reports = nightly.reports;
  files.camera = config.camera_file;
  files.zooms = config.zoom_files;
  files.spindle = config.spindle_setting.file;
  files.table = config.table_file;
  files.night_table = nightly.table.file;
  files.surface = nightly.surface.file;
  files.noon_utc_h = nightly.noon_utc_h;
  return files;
}

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
  files.table = file_of("table", "calibration");
  const auto night_file_of = [&](std::string_view table) {
    const auto name = document["nightly"][table]["file"].value<std::string>();
    return name && !name->empty() ? machine_toml.parent_path() / *name : path();
  };
  files.night_table = night_file_of("table");
  files.surface = night_file_of("surface");
  if (const toml::array* const zooms = document["camera"]["zoom"].as_array()) {
    for (const toml::node& zoom : *zooms) {
      const toml::node_view<const toml::node> entry(zoom);
      const auto level = entry["level"].value<double>();
      const auto name = entry["calibration"].value<std::string>();
      if (level && name && !name->empty()) files.zooms[*level] = machine_toml.parent_path() / *name;
    }
  }
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
  const auto note = [&](Expected<std::string> line) -> Expected<void> {
    if (!line) return failure(std::move(line).error());
    if (!line->empty()) done.push_back(*std::move(line));
    return {};
  };
  if (!files.camera.empty()) {
    PANELCAL_CHECK(note(restore_camera(config, std::nullopt, files.camera, ledger)));
  }
  for (const auto& [level, file] : files.zooms) {
    // That of [camera] is one of them where the camera says at which level it stands.
    if (file.lexically_normal() == files.camera.lexically_normal()) continue;
    PANELCAL_CHECK(note(restore_camera(config, level, file, ledger)));
  }
  if (!files.spindle.empty()) PANELCAL_CHECK(note(restore_spindle(config, ledger)));
  if (!files.table.empty()) {
    PANELCAL_CHECK(note(restore(files.table,
                                table_key(config),
                                kMaxTableCalibrationBytes,
                                parse_table_calibration,
                                ledger)));
  }
  return done;
}

}  // namespace panelcal
