// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/record/night_files.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/kinds/kinds.h"
#include "machine/calibrate/kinds/spindle_camera.h"
#include "machine/config/machine_config.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/config/toml/toml_table.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using std::filesystem::path;

/// Empty if there was nothing to do.
Expected<std::string> restore(const Calibration& calibration, const Ledger& ledger) {
  const path file = calibration.file();
  const Expected<std::string> bytes = read_file(file, kMaxLedgerResultBytes);
  Expected<void> present;
  if (!bytes) {
    present = failure(bytes.error());
  } else if (const auto date = calibration.date_of(*bytes, file.string()); !date) {
    present = failure(date.error());
  }
  if (present) return std::string();
  PANELCAL_TRY(const bool is_written, calibration.write_in_force(ledger));
  if (!is_written) return std::string();
  return fmt::format("{} could not be read ({}): written again from the ledger",
                     quoted(file.string(), 200),
                     present.error().message());
}

/// Those whose files machine.toml cannot be read without.
std::vector<std::unique_ptr<Calibration>> needed_calibrations(const NightFiles& files) {
  const auto config = std::make_shared<MachineConfig>();
  config->name = files.machine;
  config->camera_file = files.camera;
  config->zoom_files = files.zooms;
  config->spindle_setting.file = files.spindle;
  std::vector<std::unique_ptr<Calibration>> all;
  all.push_back(camera_kind(config, {}, std::nullopt));
  for (const auto& [level, file] : files.zooms) {
    // That of [camera] is one of them where the camera says at which level it stands.
    if (file.lexically_normal() == files.camera.lexically_normal()) continue;
    all.push_back(camera_kind(config, {}, level));
  }
  all.push_back(spindle_camera_kind(config));
  all.push_back(table_kind(config, {}, {}, files.table));
  return all;
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
  const auto file_of = [&](const toml::node_view<const toml::node>& value) {
    const std::string name = value.value<std::string>().value_or("");
    return name.empty() ? path() : machine_toml.parent_path() / name;
  };
  const toml::node_view<const toml::node> top(document);
  NightFiles files;
  files.machine = top["machine"]["name"].value<std::string>().value_or("");
  files.ledger = file_of(top["ledger"]["file"]);
  files.reports = file_of(top["nightly"]["reports"]);
  files.camera = file_of(top["camera"]["calibration"]);
  files.spindle = file_of(top["spindle"]["calibration"]);
  files.table = file_of(top["table"]["calibration"]);
  files.night_table = file_of(top["nightly"]["table"]["file"]);
  files.surface = file_of(top["nightly"]["surface"]["file"]);
  if (const toml::array* const zooms = top["camera"]["zoom"].as_array()) {
    for (const toml::node& zoom : *zooms) {
      const toml::node_view<const toml::node> entry(zoom);
      const auto level = entry["level"].value<double>();
      const path file = file_of(entry["calibration"]);
      if (level && !file.empty()) files.zooms[*level] = file;
    }
  }
  const auto noon = top["nightly"]["noon_utc_h"].value<std::int64_t>();
  if (noon && *noon >= 0 && *noon <= 23) files.noon_utc_h = static_cast<int>(*noon);
  return files;
}

Expected<std::vector<std::string>> restore_damaged_files(const NightFiles& files) {
  std::vector<std::string> done;
  std::error_code ignored;
  if (files.ledger.empty() || !std::filesystem::exists(files.ledger, ignored)) return done;
  PANELCAL_TRY(const Ledger ledger, Ledger::open_to_read(files.ledger));
  PANELCAL_CHECK(ledger.verify());
  for (const auto& calibration : needed_calibrations(files)) {
    if (calibration->file().empty()) continue;
    PANELCAL_TRY(std::string line, restore(*calibration, ledger));
    if (!line.empty()) done.push_back(std::move(line));
  }
  return done;
}

}  // namespace panelcal
