// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "calib/base/expected.h"
#include "machine/config/toml_table.h"
#include "machine/nightly/night_config.h"

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

inline constexpr Range kAboveZero_um{0, 1e6, true};

/// A number in um, stored in mm, where it is given.
Expected<void> read_um_in_mm(const TomlTable& table, std::string_view key, double& value_mm);

}  // namespace panelcal::internal
