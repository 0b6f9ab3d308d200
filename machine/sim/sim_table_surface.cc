// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/sim_table_surface.h"

#include <algorithm>
#include <cstdint>

#include "machine/sim/random_streams.h"

namespace panelcal {

SimulatedProbeOptions SimTableSurface::at(std::chrono::sys_seconds time) const {
  SimulatedProbeOptions out = surface;
  const std::chrono::duration<double, std::chrono::days::period> since_then = time - since;
  const double days = std::max(0.0, since_then.count());
  out.height = surface.height + days * height_per_day;
  out.slope_x_ppm += days * slope_ppm_per_day.x();
  out.slope_y_ppm += days * slope_ppm_per_day.y();
  if (time >= chip_since) out.chip = chip;
  Random nights = internal::random_of(
      surface.seed, internal::RandomStream::Nights, time.time_since_epoch().count());
  out.seed = static_cast<std::uint64_t>(nights.uniform() * 0x1p53);
  return out;
}

}  // namespace panelcal
