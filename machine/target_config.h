// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "panelcal/calib/base/expected.h"
#include "panelcal/machine/toml_table.h"
#include "panelcal/vision/target.h"

// Not installed: parts of machine.toml.
namespace panelcal::internal {

/// The keys of [[vision.tool]].
extern const TomlKeys kTargetKeys;

/// Reads one [[vision.tool]].
///
/// In     folder: where machine.toml is, from which a template's file name counts
/// Fails  config-value; target-invalid; what reading the template's picture reports
Expected<Target> read_target(const TomlTable& table,
                             bool has_camera,
                             const std::filesystem::path& folder);

}  // namespace panelcal::internal
