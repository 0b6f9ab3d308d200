// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/uncertainty_config.h"

#include <array>
#include <chrono>
#include <string_view>

#include <fmt/format.h>

#include "panelcal/calib/base/clock.h"
#include "panelcal/machine/sim_config.h"

namespace panelcal {
namespace internal {
namespace {

constexpr std::array<std::string_view, 3> kSpindleKeys = {
    "camera_offset_date", "camera_offset_mm", "camera_offset_sigma_um"};
constexpr std::array<std::string_view, 4> kUncertaintyKeys = {
    "drift_um_per_sqrt_day", "drill_wander_um", "stage_repeatability_um", "table_residual_um"};
constexpr Range kPlace{-kMaxPlace_mm, kMaxPlace_mm};
constexpr Range kSigma_um{0, 1e6};

Expected<void> read_spindle(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.table("spindle", "[spindle]", {kSpindleKeys, {}}));
  if (!table) return {};
  PANELCAL_TRY(const auto offset_mm, table->pair("camera_offset_mm", kPlace));
  if (offset_mm) config.spindle_camera.offset = displacement_mm<frame::Machine>(*offset_mm);
  PANELCAL_TRY(const double sigma_um, table->number_or("camera_offset_sigma_um", kSigma_um, 0));
  const double sigma_mm = um(sigma_um).in_mm();
  config.spindle_camera.cov_mm2 = sigma_mm * sigma_mm * Eigen::Matrix2d::Identity();
  PANELCAL_TRY(const auto date, table->wall_time("camera_offset_date"));
  if (date) {
    config.offset_date = OffsetDate{*date, table->problem("camera_offset_date", "").place};
  }
  return {};
}

Expected<void> read_terms(const TomlTable& top, MachineConfig& config) {
  PANELCAL_TRY(const auto table, top.table("uncertainty", "[uncertainty]", {kUncertaintyKeys, {}}));
  if (!table) return {};
  MachineUncertainty& machine = config.walk.uncertainty;
  PANELCAL_TRY(const double stage_um, table->number_or("stage_repeatability_um", kSigma_um, 0));
  machine.stage_repeatability = um(stage_um);
  PANELCAL_TRY(const double table_um, table->number_or("table_residual_um", kSigma_um, 0));
  machine.table_residual = um(table_um);
  PANELCAL_TRY(const double wander_um, table->number_or("drill_wander_um", kSigma_um, 0));
  machine.drill_wander = um(wander_um);
  PANELCAL_TRY(config.drift_um_per_sqrt_day,
               table->number_or("drift_um_per_sqrt_day", kSigma_um, 0));
  if (config.drift_um_per_sqrt_day > 0 && !config.offset_date) {
    return failure(table->problem("drift_um_per_sqrt_day",
                                  "[spindle] camera_offset_date as well",
                                  "it is not known since when the offset drifts"));
  }
  return {};
}

}  // namespace

Expected<void> read_uncertainty_config(const TomlTable& top, MachineConfig& config) {
  PANELCAL_CHECK(read_spindle(top, config));
  PANELCAL_CHECK(read_terms(top, config));
  MachineUncertainty& machine = config.walk.uncertainty;
  machine.spindle_camera_mm2 = config.spindle_camera.cov_mm2;
  if (config.camera) machine.camera = config.camera->covariance;
  for (const auto& [level, calibration] : config.zooms) {
    machine.zooms[level] = calibration.covariance;
  }
  return {};
}

}  // namespace internal

Expected<void> age_spindle_camera(MachineConfig& config, std::chrono::sys_seconds now) {
  if (!config.offset_date) return {};
  const auto [date, place] = *config.offset_date;
  // A wall has no time zone, and the letter for one is not to be seen on it.
  const auto on_wall = [](std::chrono::sys_seconds time) {
    std::string text = iso_8601(time);
    text.pop_back();
    return text;
  };
  if (date > now) {
    return failure({Code::ConfigValue,
                    place,
                    "camera_offset_date in [spindle] is " + on_wall(date) + ", in the future",
                    "at the latest now, " + on_wall(now)});
  }
  const double age_days =
      std::chrono::duration<double, std::chrono::days::period>(now - date).count();
  const double drift_mm = um(config.drift_um_per_sqrt_day).in_mm();
  config.walk.uncertainty.drift_mm2 = drift_mm * drift_mm * age_days * Eigen::Matrix2d::Identity();
  return {};
}

}  // namespace panelcal
