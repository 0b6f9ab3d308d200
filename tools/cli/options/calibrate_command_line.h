// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/cli/options/calibrate_options.h"

namespace CLI {
class App;
}

namespace panelcal {

/// Adds what `panelcal calibrate` understands; `options` must outlive `calibrate`.
void add_calibrate_commands(CLI::App& calibrate, CalibrateOptions& options);

}  // namespace panelcal
