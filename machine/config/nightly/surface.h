// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "calib/base/expected.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/config/toml/toml_table.h"

// Not installed: parts of reading [nightly] of machine.toml.
namespace panelcal::internal {

/// [nightly.surface], which "surface" among what is calibrated needs.
///
/// In     folder: where machine.toml is
Expected<void> read_night_surface(const TomlTable& nightly,
                                  const std::filesystem::path& folder,
                                  NightlyConfig& config);

}  // namespace panelcal::internal
