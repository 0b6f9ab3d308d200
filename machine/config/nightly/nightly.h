// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "calib/base/expected.h"
#include "machine/config/settings/nightly_options.h"
#include "machine/config/toml/toml_table.h"

// Not installed: parts of machine.toml.
namespace panelcal::internal {

/// Reads [nightly], [nightly.gates] and [nightly.drift] of a machine.toml.
///
/// In     top: the whole file; folder: where it is, from which `reports`, `temperature_file` and a
///        program with a relative path count
/// Out    empty without [nightly]
/// Fails  config-key-unknown; config-value
/// See    tests/machine/nightly/night_config_test.cc
Expected<std::optional<NightlyConfig>> read_nightly_config(const TomlTable& top,
                                                           const std::filesystem::path& folder);

}  // namespace panelcal::internal
