// SPDX-License-Identifier: Apache-2.0
#include "machine/config/sim/surface.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "calib/base/fields/slots.h"
#include "machine/config/sections/sections.h"
#include "machine/config/toml/ranges.h"

namespace panelcal::internal {
namespace {

/// How the table's surface moves. A chip is there only with all of its keys.
struct SurfaceMotionKeys {
  SimTableSurface table;
  SimulatedChip chip;
};

constexpr std::size_t kMaxAxes = 64;
constexpr Range kSlope_ppm{-1e5, 1e5};
constexpr Range kSurfaceHeight_um{-1e5, 1e5};
constexpr Range kRadius_mm{0, kMaxPlace_mm, true};

/// A surface that no key says more of is flat and probed without noise.
SimulatedProbeOptions plain_surface() {
  SimulatedProbeOptions surface;
  surface.noise_sigma = Length();
  return surface;
}

#include "machine/config/sim/surface.def"

/// All of it, or none.
Expected<void> take_chip(const TomlTable& table,
                         const SurfaceMotionKeys& keys,
                         SimTableSurface& surface) {
  constexpr std::array<std::string_view, 4> kAll = {
      "chip_depth_um", "chip_mm", "chip_radius_mm", "chip_since"};
  const auto has = [&](std::string_view key) { return table.has(key); };
  if (std::ranges::none_of(kAll, has)) return {};
  for (const std::string_view key : kAll) {
    if (!has(key)) {
      return failure(
          table.missing(key, "all of chip_depth_um, chip_mm, chip_radius_mm, chip_since"));
    }
  }
  surface.chip = keys.chip;
  return {};
}

}  // namespace

Section sim_surface_section() {
  return {kSimSurfaceTables, nullptr};
}

Expected<void> read_sim_surface(const TomlTable& sim, SimulatedProbeOptions& surface) {
  PANELCAL_TRY(const auto table, sim.read_table(kBoard, surface));
  if (!surface.axis_offsets.empty() && surface.axis_offsets.size() <= kMaxAxes) return {};
  return failure(table->problem("axis_offsets_um", "one for each Z axis, 1 to 64 of them"));
}

Expected<void> read_sim_table_surface(const TomlTable& sim,
                                      std::uint64_t seed,
                                      std::optional<SimTableSurface>& out) {
  SurfaceMotionKeys keys;
  SimTableSurface& surface = keys.table;
  surface.surface = plain_surface();
  surface.surface.seed = seed;
  surface.surface.height = Length();
  PANELCAL_TRY(const auto table, sim.read_table(kTableShape, surface.surface));
  if (!table) return {};
  PANELCAL_CHECK(table->read(kTableMotion, keys));
  for (const std::string_view key : {"height_um_per_day", "slope_ppm_per_day"}) {
    if (table->has(key) && !table->has("since")) {
      return failure(table->problem(key, "since as well", "it has no date to begin at"));
    }
  }
  PANELCAL_CHECK(take_chip(*table, keys, surface));
  out = surface;
  return {};
}

}  // namespace panelcal::internal
