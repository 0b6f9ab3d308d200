// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/config/settings/machine.h"
#include "machine/config/toml/toml_table.h"

// Not installed: parts of machine.toml.
namespace panelcal::internal {

/// Reads [spindle] (camera_offset_mm, camera_offset_sigma_um, camera_offset_date; or calibration,
/// number, station) and the calibration file it names.
///
/// Fails  config-key-unknown; config-value (both a calibration and a sigma or a date; no
///        camera_offset_mm to begin with where there is no calibration yet); what
///        read_spindle_calibration reports
Expected<void> read_spindle_config(const TomlTable& top, MachineConfig& config);

/// Reads [ledger] file.
Expected<void> read_ledger_config(const TomlTable& top, MachineConfig& config);

}  // namespace panelcal::internal
