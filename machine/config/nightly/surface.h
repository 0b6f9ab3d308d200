// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/config/toml/toml_table.h"

// Not installed: parts of reading [nightly] of machine.toml.
namespace panelcal::internal {

/// Reads [nightly.surface], which "surface" among what is calibrated needs.
Expected<void> read_night_surface(const TomlTable& nightly, NightlyConfig& config);

}  // namespace panelcal::internal
