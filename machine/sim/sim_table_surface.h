// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "machine/config/settings/sim_options.h"

namespace panelcal {

/// The surface at a time. Its probe's noise is another one each second, and the same again if
/// asked for the same time.
SimulatedProbeOptions surface_at(const SimTableSurface& table, std::chrono::sys_seconds time);

}  // namespace panelcal
