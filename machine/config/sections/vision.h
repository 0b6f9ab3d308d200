// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/config/settings/machine.h"
#include "machine/config/toml/toml_table.h"

// Not installed: parts of machine.toml.
namespace panelcal::internal {

/// [vision] search_radius_mm, search_area_mm, four_views, four_view_limit_um, algorithms.
Expected<void> read_vision_options(const TomlTable& vision, VisionOptions& options);

/// [camera] focus_mm, focus_range_mm, lamp and the calibrations of [[camera.zoom]], beside that of
/// [camera].
///
/// Fails  config-value; what calibration_file reports
Expected<void> read_zoom_and_focus(const TomlTable& camera, MachineConfig& config);

}  // namespace panelcal::internal
