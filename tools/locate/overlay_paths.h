// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "tools/cli/commands.h"

namespace panelcal::internal {

/// Names the command that is not understood.
Diagnostic locate_usage(std::string what, std::string expected);

/// Path of the overlay of each picture: OUT.png for the only one, else OUT/NAME.png, of which the
/// folder is made.
///
/// Fails  usage (no PNG; several pictures and one file; two pictures of one name); output-in-use;
///        device-write
Expected<std::vector<std::filesystem::path>> make_overlay_paths(const LocateCommandOptions& options,
                                                                const CommandContext& context);

}  // namespace panelcal::internal
