// SPDX-License-Identifier: Apache-2.0
#include "machine/config/sections/spindle.h"

#include <array>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "machine/config/toml/ranges.h"
#include <fmt/format.h>

namespace panelcal {
namespace internal {
namespace {

constexpr std::array<std::string_view, 6> kSpindleKeys = {"calibration",
                                                          "camera_offset_date",
                                                          "camera_offset_mm",
                                                          "camera_offset_sigma_um",
                                                          "number",
                                                          "station"};
constexpr std::array<std::string_view, 1> kLedgerKeys = {"file"};
constexpr Range kSpindleSigma_um{0, 1e6};

/// The offset that stands in machine.toml itself.
Expected<void> read_stated(const TomlTable& table, MachineConfig& config) {
  PANELCAL_TRY(const double sigma_um,
               table.number_or("camera_offset_sigma_um", kSpindleSigma_um, 0));
  const double sigma_mm = um(sigma_um).in_mm();
  config.spindle_camera.cov_mm2 = sigma_mm * sigma_mm * Eigen::Matrix2d::Identity();
  PANELCAL_TRY(const auto date, table.wall_time("camera_offset_date"));
  if (date) {
    config.offset_date = OffsetDate{*date, table.problem("camera_offset_date", "").place};
  }
  return {};
}

Expected<void> read_which(const TomlTable& table, SpindleSetting& setting) {
  PANELCAL_TRY(const auto number, table.integer("number", 1, kMostSpindles));
  if (number) setting.spindle = static_cast<int>(*number);
  PANELCAL_TRY(const auto station, table.integer("station", 1, kMostStations));
  if (station) setting.station = static_cast<int>(*station);
  return {};
}

Expected<void> read_calibrated(const TomlTable& table,
                               const std::string& file,
                               bool has_offset,
                               MachineConfig& config) {
  for (const std::string_view key : {"camera_offset_sigma_um", "camera_offset_date"}) {
    if (!table.has(key)) continue;
    return failure(table.problem(
        key, "[spindle] without it", "the calibration that it names states this as well"));
  }
  if (file.empty()) return failure(table.problem("calibration", "the name of a file"));
  SpindleSetting& setting = config.spindle_setting;
  setting.file = config.file.parent_path() / file;
  std::error_code ignored;
  // Only what is certainly not there has still to be made; what cannot be read is an error.
  const auto status = std::filesystem::symlink_status(setting.file, ignored);
  if (status.type() != std::filesystem::file_type::not_found) {
    PANELCAL_TRY(setting.calibration, read_spindle_calibration(setting.file));
  }
  PANELCAL_CHECK(select_spindle(config, {setting.spindle, setting.station}));
  if (setting.is_calibrated || has_offset) return {};
  return failure(table.missing(
      "camera_offset_mm to begin with",
      fmt::format("camera_offset_mm = [x, y] as long as {} does not have spindle {} at station {}",
                  quoted(file),
                  setting.spindle,
                  setting.station)));
}

}  // namespace

Expected<void> read_spindle_config(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.table("spindle", "[spindle]", {kSpindleKeys, {}}));
  if (!table) return {};
  PANELCAL_TRY(const auto offset_mm, table->pair("camera_offset_mm", kPlace));
  if (offset_mm) {
    config.spindle_camera.offset = displacement_mm<frame::Machine>(*offset_mm);
    config.spindle_setting.stated_offset = config.spindle_camera.offset;
  }
  PANELCAL_CHECK(read_which(*table, config.spindle_setting));
  PANELCAL_TRY(const auto file, table->text("calibration"));
  if (!file) return read_stated(*table, config);
  return read_calibrated(*table, *file, offset_mm.has_value(), config);
}

Expected<void> read_ledger_config(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.table("ledger", "[ledger]", {kLedgerKeys, {}}));
  if (!table) return {};
  PANELCAL_TRY(const auto file, table->text("file"));
  if (!file) return failure(table->missing("file", "file = \"NAME.ledger\""));
  if (file->empty()) return failure(table->problem("file", "the name of a file"));
  config.ledger_file = config.file.parent_path() / *file;
  return {};
}

}  // namespace internal

Expected<void> select_spindle(MachineConfig& config, SpindleAt at) {
  if (at.spindle < 1 || at.spindle > kMostSpindles || at.station < 1 ||
      at.station > kMostStations) {
    return failure(
        {Code::ConfigValue,
         {config.file.string(), 0, 0},
         fmt::format("there is no spindle {} at station {}", at.spindle, at.station),
         fmt::format("spindles 1 to {}, stations 1 to {}", kMostSpindles, kMostStations)});
  }
  SpindleSetting& setting = config.spindle_setting;
  setting.spindle = at.spindle;
  setting.station = at.station;
  if (setting.file.empty()) return {};
  const SpindleCameraOffset* const offset = setting.calibration.offsets.find(at);
  setting.is_calibrated = offset != nullptr;
  config.offset_date.reset();
  if (offset == nullptr) {
    if (setting.stated_offset) config.spindle_camera.offset = *setting.stated_offset;
    config.spindle_camera.cov_mm2.setZero();
  } else {
    config.spindle_camera = *offset;
    config.offset_date =
        OffsetDate{setting.calibration.date_of(at), {setting.file.string(), 0, 0}, true};
  }
  config.walk.uncertainty.spindle_camera_mm2 = config.spindle_camera.cov_mm2;
  return {};
}

Expected<void> check_spindle_is_calibrated(const MachineConfig& config) {
  const SpindleSetting& setting = config.spindle_setting;
  if (setting.is_calibrated) return {};
  return failure({Code::ConfigValue,
                  {setting.file.string(), 0, 0},
                  fmt::format("the offset of spindle {} at station {} was never calibrated: "
                              "the places of its holes are not known",
                              setting.spindle,
                              setting.station),
                  "a calibration: `panelcal calibrate spindle-camera --install`"});
}

}  // namespace panelcal
