// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/cli/options/surface_options.h"

namespace CLI {
class App;
}

namespace panelcal {

/// Adds what `panelcal surface` understands; `options` must outlive `surface`.
void add_surface_commands(CLI::App& surface, SurfaceOptions& options);

}  // namespace panelcal
