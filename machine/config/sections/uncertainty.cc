// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <chrono>

#include "calib/base/clock.h"
#include "calib/base/fields/slots.h"
#include "calib/camera/calibration/shared_error.h"
#include "machine/config/sections/sections.h"
#include <fmt/format.h>

namespace panelcal {
namespace internal {
namespace {

constexpr Range kTermSigma_um{0, 1e6};

#include "machine/config/sections/uncertainty.def"

Expected<void> read_terms(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.read_table(kUncertainty, config));
  if (!table) return {};
  MachineUncertainty& machine = config.walk.uncertainty;
  machine.states_stage = table->has("stage_repeatability_um");
  machine.states_table = table->has("table_residual_um");
  machine.states_wander = table->has("drill_wander_um");
  // Before its first calibration no hole is placed, and nothing drifts.
  const bool knows_since = config.offset_date || !config.spindle_setting.is_calibrated;
  if (config.drift_um_per_sqrt_day > 0 && !knows_since) {
    return failure(table->problem("drift_um_per_sqrt_day",
                                  "the date of the calibration",
                                  "missing key \"camera_offset_date\" of [spindle]"));
  }
  return {};
}

Expected<void> read_uncertainty(const TomlTable& top, MachineConfig& config) {
  PANELCAL_CHECK(read_terms(top, config));
  MachineUncertainty& machine = config.walk.uncertainty;
  machine.spindle_camera_mm2 = config.spindle_camera.cov_mm2;
  if (config.camera) machine.camera = SharedCameraError(*config.camera).covariance();
  for (const auto& [level, calibration] : config.zooms) {
    machine.zooms[level] = SharedCameraError(calibration).covariance();
  }
  return {};
}

}  // namespace

Section uncertainty_section() {
  return {kUncertaintyTables, read_uncertainty};
}

}  // namespace internal

Expected<void> age_spindle_camera(MachineConfig& config, std::chrono::sys_seconds now) {
  if (!config.offset_date) return {};
  const auto [date, place, is_utc] = *config.offset_date;
  const auto by_clock = [is_utc = is_utc](std::chrono::sys_seconds time) {
    std::string text = iso_8601(time);
    // A wall has no time zone, and the letter for one is not to be seen on it.
    if (!is_utc) text.pop_back();
    return text;
  };
  if (date > now) {
    return failure(
        {Code::ConfigValue,
         place,
         fmt::format("{} is {}, in the future",
                     config.spindle_setting.file.empty() ? "camera_offset_date in [spindle]"
                                                         : "the date of the spindle-camera offset",
                     by_clock(date)),
         "at the latest now, " + by_clock(now)});
  }
  const double age_days =
      std::chrono::duration<double, std::chrono::days::period>(now - date).count();
  const double drift_mm = um(config.drift_um_per_sqrt_day).in_mm();
  config.walk.uncertainty.drift_mm2 = drift_mm * drift_mm * age_days * Eigen::Matrix2d::Identity();
  return {};
}

}  // namespace panelcal
