// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "tools/cli/options/options.h"

namespace panelcal {

/// Reads the command line; prints help and version itself.
///
/// Fails  usage
Expected<Options> parse_options(int argc, char** argv);

}  // namespace panelcal
