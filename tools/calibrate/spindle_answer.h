// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "calib/base/json/facts.h"
#include "calib/correction/spindle_camera.h"
#include "machine/calibrate/spindle/camera_run.h"
#include "machine/config/machine_config.h"
#include <Eigen/Core>

// Answers of `panelcal calibrate spindle-camera`.
namespace panelcal::calibrate {

/// A new offset against the present one.
struct SpindleAnswer {
  int spindle = 1;
  int station = 1;
  bool is_first = false;  ///< the present one was only where to begin
  SpindleCameraOffset before;
  Eigen::Vector2d shift_um = Eigen::Vector2d::Zero();
  /// Of the shift: both offsets' and the drift since the present one's date.
  Eigen::Vector2d sigma_um = Eigen::Vector2d::Zero();
  /// Chance of so large a shift where nothing moved; absent for a first one.
  std::optional<double> chance;
  /// The nights' gates that a requested installation is held to.
  facts::Json gates = facts::Json::array();
  bool is_installed = false;
  std::string refusal;  ///< the reason if a requested installation was refused
  std::optional<std::int64_t> ledger_id;
};

SpindleAnswer compare(const MachineConfig& config, const SpindleCameraRun& run);

/// The reasons against the fit: residuals with a significant trend; empty if nothing.
std::string trend_words(const SpindleCameraFit& fit);

std::string text(const SpindleAnswer& answer, const SpindleCameraRun& run);
/// The part of the document of facts that such an offset alone has.
facts::Json spindle_facts(const SpindleAnswer& answer, const SpindleCameraRun& run);

}  // namespace panelcal::calibrate
