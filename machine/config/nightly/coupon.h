// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "calib/base/expected.h"
#include "machine/config/settings/coupon_options.h"
#include "machine/config/toml/toml_table.h"

// Not installed: parts of machine.toml.
namespace panelcal::internal {

/// Reads [coupon] of a machine.toml: name, origin_mm, columns, rows, rows_per_run, pitch_mm,
/// drill_tool, vision_tool, entry_material, drill_approach, approaches, approach_mm, state.
///
/// In     top: the whole file; folder: where it is, from which `state` counts
/// Out    empty without [coupon]
/// Fails  config-key-unknown; config-value
Expected<std::optional<Coupon>> read_coupon_config(const TomlTable& top,
                                                   const std::filesystem::path& folder);

}  // namespace panelcal::internal
