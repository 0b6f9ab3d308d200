// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "calib/base/expected.h"
#include "machine/config/settings/sim_options.h"
#include "machine/config/toml/toml_table.h"

// Not installed: the surfaces of [sim] in machine.toml.
namespace panelcal::internal {

/// [sim.surface]: the board's. Without a word it is flat, where it is expected, and probed without
/// noise.
Expected<void> read_sim_surface(const TomlTable& sim, SimulatedProbeOptions& surface);

/// [sim.table_surface]: the table's own; absent: the virtual machine cannot probe it.
Expected<void> read_sim_table_surface(const TomlTable& sim,
                                      std::uint64_t seed,
                                      std::optional<SimTableSurface>& out);

}  // namespace panelcal::internal
