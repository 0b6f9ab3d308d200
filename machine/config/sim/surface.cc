// SPDX-License-Identifier: Apache-2.0
#include "machine/config/sim/surface.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "machine/config/toml/ranges.h"

namespace panelcal::internal {
namespace {

constexpr std::array<std::string_view, 7> kBoardKeys = {"axis_offsets_um",
                                                        "bow_center_mm",
                                                        "bow_radius_mm",
                                                        "bow_um",
                                                        "height_mm",
                                                        "noise_um",
                                                        "slope_ppm"};
constexpr std::array<std::string_view, 13> kSimSurfaceKeys = {"bow_center_mm",
                                                              "bow_radius_mm",
                                                              "bow_um",
                                                              "chip_depth_um",
                                                              "chip_mm",
                                                              "chip_radius_mm",
                                                              "chip_since",
                                                              "height_mm",
                                                              "height_um_per_day",
                                                              "noise_um",
                                                              "since",
                                                              "slope_ppm",
                                                              "slope_ppm_per_day"};

constexpr std::size_t kMaxAxes = 64;
constexpr Range kSurfacePpm{-1e5, 1e5};
constexpr Range kSurfaceHeight_um{-1e5, 1e5};

/// Reads the keys of both surfaces.
Expected<void> read_surface_shape(const TomlTable& table, SimulatedProbeOptions& surface) {
  PANELCAL_TRY(const auto height_mm, table.number("height_mm", kPlace));
  if (height_mm) surface.height = mm(*height_mm);
  PANELCAL_TRY(const auto slope_ppm, table.pair("slope_ppm", kSurfacePpm));
  if (slope_ppm) {
    surface.slope_x_ppm = slope_ppm->x();
    surface.slope_y_ppm = slope_ppm->y();
  }
  PANELCAL_TRY(const double bow_um, table.number_or("bow_um", kSurfaceHeight_um, 0));
  surface.bow = um(bow_um);
  PANELCAL_TRY(const auto center_mm, table.pair("bow_center_mm", kPlace));
  if (center_mm) surface.bow_center = position_mm<frame::Actual>(*center_mm);
  PANELCAL_TRY(const auto radius_mm, table.number("bow_radius_mm", {0, kMaxPlace_mm, true}));
  if (radius_mm) surface.bow_radius = mm(*radius_mm);
  PANELCAL_TRY(const double noise_um, table.number_or("noise_um", {0, 1e5}, 0));
  surface.noise_sigma = um(noise_um);
  return {};
}

/// All of it, or none.
Expected<void> read_chip(const TomlTable& table, SimTableSurface& surface) {
  PANELCAL_TRY(const auto place_mm, table.pair("chip_mm", kPlace));
  PANELCAL_TRY(const auto radius_mm, table.number("chip_radius_mm", {0, kMaxPlace_mm, true}));
  PANELCAL_TRY(const auto depth_um, table.number("chip_depth_um", {0, 1e5, true}));
  PANELCAL_TRY(const auto since, table.wall_time("chip_since"));
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
  surface.chip =
      SimulatedChip{position_mm<frame::Actual>(*place_mm), mm(*radius_mm), um(*depth_um)};
  surface.chip_since = *since;
  return {};
}

}  // namespace

Expected<void> read_sim_surface(const TomlTable& sim, SimulatedProbeOptions& surface) {
  PANELCAL_TRY(const auto table, sim.table("surface", "[sim.surface]", {kBoardKeys, {}}));
  if (!table) return {};
  PANELCAL_CHECK(read_surface_shape(*table, surface));
  PANELCAL_TRY(const auto offsets_um, table->numbers("axis_offsets_um", kSurfaceHeight_um));
  if (!offsets_um) return {};
  if (offsets_um->empty() || offsets_um->size() > kMaxAxes) {
    return failure(table->problem("axis_offsets_um", "one for each Z axis, 1 to 64 of them"));
  }
  surface.axis_offsets.clear();
  for (const double offset_um : *offsets_um) surface.axis_offsets.push_back(um(offset_um));
  return {};
}

Expected<void> read_sim_table_surface(const TomlTable& sim,
                                      std::uint64_t seed,
                                      std::optional<SimTableSurface>& out) {
  PANELCAL_TRY(const auto table,
               sim.table("table_surface", "[sim.table_surface]", {kSimSurfaceKeys, {}}));
  if (!table) return {};
  SimTableSurface& surface = out.emplace();
  surface.surface.seed = seed;
  surface.surface.height = Length();
  PANELCAL_CHECK(read_surface_shape(*table, surface.surface));
  PANELCAL_TRY(const auto since, table->wall_time("since"));
  surface.since = since.value_or(std::chrono::sys_seconds());
  for (const std::string_view key : {"height_um_per_day", "slope_ppm_per_day"}) {
    if (table->has(key) && !since) {
      return failure(table->problem(key, "since as well", "it has no date to begin at"));
    }
  }
  PANELCAL_TRY(const double rise_um, table->number_or("height_um_per_day", kSurfaceHeight_um, 0));
  surface.height_per_day = um(rise_um);
  PANELCAL_TRY(const auto slope_ppm, table->pair("slope_ppm_per_day", kSurfacePpm));
  if (slope_ppm) surface.slope_ppm_per_day = *slope_ppm;
  return read_chip(*table, surface);
}

}  // namespace panelcal::internal
