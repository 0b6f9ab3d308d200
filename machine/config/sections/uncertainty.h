// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/config/settings/machine.h"
#include "machine/config/toml/toml_table.h"

// Not installed: parts of machine.toml.
namespace panelcal::internal {

/// Reads [uncertainty] (stage_repeatability_um, table_residual_um, drill_wander_um, depth_um,
/// drift_um_per_sqrt_day), and gathers it with the covariances of [spindle] and of the cameras'
/// calibrations in config.walk.uncertainty.
///
/// Precondition: [camera] and [spindle] have been read
/// Fails  config-key-unknown; config-value (a drift without camera_offset_date, whose
///        duration is unknown)
Expected<void> read_uncertainty_config(const TomlTable& top, MachineConfig& config);

}  // namespace panelcal::internal
