// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "panelcal/calib/base/expected.h"
#include "panelcal/machine/machine_config.h"
#include "panelcal/machine/toml_table.h"

// Not installed: parts of machine.toml.
namespace panelcal::internal {

/// Reads [spindle] (camera_offset_mm, camera_offset_sigma_um, camera_offset_date) and [uncertainty]
/// (stage_repeatability_um, table_residual_um, drill_wander_um, drift_um_per_sqrt_day), and gathers
/// them with the covariances of the cameras' calibrations in config.walk.uncertainty.
///
/// Precondition: [camera] has been read
/// Fails  config-key-unknown; config-value (a drift without camera_offset_date, of which nobody
///        knows how long it has gone on)
Expected<void> read_uncertainty_config(const TomlTable& top, MachineConfig& config);

}  // namespace panelcal::internal
