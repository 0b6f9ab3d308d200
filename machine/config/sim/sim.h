// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "machine/config/settings/machine.h"
#include "machine/config/toml/toml_table.h"

namespace panelcal::internal {

/// Reads [sim] of a machine.toml.
///
/// In     top: the whole file; camera: what [camera] calibrates, from which picture_px and the keys
///        of [sim.camera] are taken where they are left out; surface_height: where [surface]
///        expects the board's surface, the same for [sim.surface]
Expected<std::optional<SimConfig>> read_sim_config(const TomlTable& top,
                                                   const std::optional<CameraCalibration>& camera,
                                                   Length surface_height);

}  // namespace panelcal::internal
