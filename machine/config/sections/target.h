// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "calib/base/expected.h"
#include "calib/camera/calibration/calibration_file.h"
#include "machine/config/toml/toml_table.h"
#include "vision/fit/target.h"

// Not installed: parts of machine.toml.
namespace panelcal::internal {

/// The keys of [[vision.tool]].
extern const TomlKeys kTargetKeys;

/// Reads one [[vision.tool]].
///
/// In     camera: what [camera] calibrates; folder: where machine.toml is, from which a template's
///        file name counts
/// Fails  config-value, with line and column, also of a target that no picture could tell; what
///        reading the template's picture reports
Expected<Target> read_target(const TomlTable& table,
                             const std::optional<CameraCalibration>& camera,
                             const std::filesystem::path& folder);

}  // namespace panelcal::internal
