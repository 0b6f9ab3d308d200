// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "calib/base/fields/slots.h"
#include "machine/config/sections/sections.h"
#include "machine/config/toml/ranges.h"
#include <fmt/format.h>

namespace panelcal {

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

namespace internal {
namespace {

/// camera_offset_sigma_um and camera_offset_date state what a calibration states as well.
struct SpindleKeys {
  std::optional<Displacement<frame::Machine>> offset;
  Length sigma;
  std::chrono::sys_seconds date;
  std::string calibration;
  int number = 1;
  int station = 1;
};

#include "machine/config/sections/spindle.def"

/// The offset that stands in machine.toml itself.
void take_stated(const TomlTable& table, const SpindleKeys& keys, MachineConfig& config) {
  const double sigma_mm = keys.sigma.in_mm();
  config.spindle_camera.cov_mm2 = sigma_mm * sigma_mm * Eigen::Matrix2d::Identity();
  if (!table.has("camera_offset_date")) return;
  config.offset_date = OffsetDate{keys.date, table.place_of("camera_offset_date")};
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

Expected<void> read_spindle(const TomlTable& top, MachineConfig& config) {
  PANELCAL_CHECK(top.read_table(kLedger, config));
  SpindleKeys keys;
  PANELCAL_TRY(const auto table, top.read_table(kSpindle, keys));
  if (!table) return {};
  config.spindle_setting.stated_offset = keys.offset;
  if (keys.offset) config.spindle_camera.offset = *keys.offset;
  config.spindle_setting.spindle = keys.number;
  config.spindle_setting.station = keys.station;
  if (table->has("calibration")) {
    return read_calibrated(*table, keys.calibration, keys.offset.has_value(), config);
  }
  take_stated(*table, keys, config);
  return {};
}

}  // namespace

Section spindle_section() {
  return {kSpindleTables, read_spindle};
}

}  // namespace internal

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
