// SPDX-License-Identifier: Apache-2.0
#include "machine/config/nightly/surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/base/fields/slots.h"
#include "machine/config/sections/sections.h"
#include "machine/config/toml/ranges.h"

namespace panelcal::internal {
namespace {

struct NightSurfaceKeys {
  NightSurface surface;
  std::optional<int> columns;
  std::optional<int> rows;
  std::optional<Length> spacing;
};

/// Of probed places: fewer tell no bow where one is left out, and 24 x 24 is what a map takes.
constexpr WholeRange kPlacesAlong{4, 24};

#include "machine/config/nightly/surface.def"

/// Columns and rows, or at most so far apart.
Expected<void> take_grid(const TomlTable& table,
                         const NightSurfaceKeys& keys,
                         NightSurface& surface) {
  if (keys.spacing && (keys.columns || keys.rows)) {
    return failure(table.problem("spacing_mm", "only one of the two", "there are columns or rows"));
  }
  if (keys.columns && keys.rows) {
    surface.n_columns = *keys.columns;
    surface.n_rows = *keys.rows;
    return {};
  }
  if (!keys.spacing) return failure(table.missing("columns, rows", "columns = N, rows = N"));
  const Eigen::Vector2d steps = (surface.high_mm - surface.low_mm) / keys.spacing->in_mm();
  constexpr double kMaxAlong = kPlacesAlong.high;
  const auto along = [](double n_steps) {
    // A rectangle of whole steps has no more of them by rounding.
    return std::clamp(std::ceil(n_steps - 1e-9) + 1.0, double{kPlacesAlong.low}, 2.0 * kMaxAlong);
  };
  if (along(steps.maxCoeff()) > kMaxAlong) {
    return failure(table.problem("spacing_mm", "at most 24 places along each side"));
  }
  surface.n_columns = static_cast<int>(along(steps.x()));
  surface.n_rows = static_cast<int>(along(steps.y()));
  return {};
}

}  // namespace

Section night_surface_section() {
  return {kNightSurfaceTables, nullptr};
}

Expected<void> read_night_surface(const TomlTable& nightly, NightlyConfig& config) {
  NightSurfaceKeys keys;
  PANELCAL_TRY(const auto table, nightly.read_table(kNightSurface, keys));
  const bool is_asked = std::ranges::find(config.calibrate, "surface") != config.calibrate.end();
  if (!table && !is_asked) return {};
  if (!table) {
    return failure(nightly.missing("rectangle of the table to probe", "[nightly.surface]"));
  }
  NightSurface& surface = config.surface = keys.surface;
  if (!((surface.high_mm - surface.low_mm).array() > 0).all()) {
    return failure(table->problem("high_mm", "above low_mm both ways"));
  }
  surface.place = table->place_of("high_mm");
  return take_grid(*table, keys, surface);
}

}  // namespace panelcal::internal
