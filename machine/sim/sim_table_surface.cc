// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/sim_table_surface.h"

#include <algorithm>
#include <cstdint>

#include "machine/sim/random_streams.h"

namespace panelcal {

SimulatedProbeOptions surface_at(const SimTableSurface& table, std::chrono::sys_seconds time) {
  SimulatedProbeOptions out = table.surface;
  const std::chrono::duration<double, std::chrono::days::period> since_then = time - table.since;
  const double days = std::max(0.0, since_then.count());
  out.height = table.surface.height + days * table.height_per_day;
  out.slope_x_ppm += days * table.slope_ppm_per_day.x();
  out.slope_y_ppm += days * table.slope_ppm_per_day.y();
  if (time >= table.chip_since) out.chip = table.chip;
  Random nights = internal::random_of(
      table.surface.seed, internal::RandomStream::Nights, time.time_since_epoch().count());
  out.seed = static_cast<std::uint64_t>(nights.uniform() * 0x1p53);
  return out;
}

}  // namespace panelcal
