// SPDX-License-Identifier: Apache-2.0
#include "machine/config/nightly_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "machine/config/ranges.h"

namespace panelcal::internal {
namespace {

constexpr std::array<std::string_view, 14> kNightSurfaceKeys = {"anywhere_um",
                                                                "bow_um",
                                                                "columns",
                                                                "file",
                                                                "height_mm",
                                                                "high_mm",
                                                                "low_mm",
                                                                "offset_um",
                                                                "probe_sigma_um",
                                                                "repeats",
                                                                "rows",
                                                                "sigma_um",
                                                                "spacing_mm",
                                                                "tilt_um"};

/// Of probed places: fewer tell no bow where one is left out, and 24 x 24 is what a map takes.
constexpr std::int64_t kLeastAlong = 4;
constexpr std::int64_t kMaxAlong = 24;

/// Columns and rows, or at most so far apart.
Expected<void> read_grid(const TomlTable& table, NightSurface& surface) {
  PANELCAL_TRY(const auto spacing_mm, table.number("spacing_mm", {0, kMaxPlace_mm, true}));
  PANELCAL_TRY(const auto columns, table.integer("columns", kLeastAlong, kMaxAlong));
  PANELCAL_TRY(const auto rows, table.integer("rows", kLeastAlong, kMaxAlong));
  if (spacing_mm && (columns || rows)) {
    return failure(table.problem("spacing_mm", "only one of the two", "there are columns or rows"));
  }
  if (columns && rows) {
    surface.n_columns = static_cast<int>(*columns);
    surface.n_rows = static_cast<int>(*rows);
    return {};
  }
  if (!spacing_mm) return failure(table.missing("columns, rows", "columns = N, rows = N"));
  const Eigen::Vector2d steps = (surface.high_mm - surface.low_mm) / *spacing_mm;
  const auto along = [](double n_steps) {
    // A rectangle of whole steps has no more of them by rounding.
    return std::clamp(std::ceil(n_steps - 1e-9) + 1.0, double{kLeastAlong}, 2.0 * kMaxAlong);
  };
  if (along(steps.maxCoeff()) > kMaxAlong) {
    return failure(table.problem("spacing_mm", "at most 24 places along each side"));
  }
  surface.n_columns = static_cast<int>(along(steps.x()));
  surface.n_rows = static_cast<int>(along(steps.y()));
  return {};
}

}  // namespace

Expected<void> read_night_surface(const TomlTable& nightly,
                                  const std::filesystem::path& folder,
                                  NightlyConfig& config) {
  const bool is_asked = std::ranges::find(config.calibrate, "surface") != config.calibrate.end();
  PANELCAL_TRY(const auto table,
               nightly.table("surface", "[nightly.surface]", {kNightSurfaceKeys, {}}));
  if (!table && !is_asked) return {};
  if (!table) {
    return failure(nightly.missing("rectangle of the table to probe", "[nightly.surface]"));
  }
  PANELCAL_CHECK(table->require({{"file", "file = \"NAME.json\", the map that nights write"},
                                 {"low_mm", "low_mm = [x, y]"},
                                 {"high_mm", "high_mm = [x, y]"}}));
  NightSurface& surface = config.surface;
  PANELCAL_TRY(const auto file, table->text("file"));
  if (!file || file->empty()) {
    return failure(table->missing("file", "file = \"NAME.json\", the map that nights write"));
  }
  surface.file = folder / *file;
  PANELCAL_TRY(const auto low_mm, table->pair("low_mm", kPlace));
  PANELCAL_TRY(const auto high_mm, table->pair("high_mm", kPlace));
  if (!((*high_mm - *low_mm).array() > 0).all()) {
    return failure(table->problem("high_mm", "above low_mm both ways"));
  }
  surface.low_mm = *low_mm;
  surface.high_mm = *high_mm;
  surface.place = table->problem("high_mm", "").place;
  PANELCAL_CHECK(read_grid(*table, surface));
  PANELCAL_TRY(const auto height_mm, table->number("height_mm", kPlace));
  if (height_mm) surface.height = mm(*height_mm);
  PANELCAL_TRY(const auto repeats, table->integer("repeats", 1, 100));
  if (repeats) surface.n_repeats = static_cast<int>(*repeats);
  for (const auto& [key, length] : {std::pair("anywhere_um", &surface.anywhere),
                                    std::pair("bow_um", &surface.bow),
                                    std::pair("offset_um", &surface.offset),
                                    std::pair("probe_sigma_um", &surface.probe_sigma),
                                    std::pair("sigma_um", &surface.sigma),
                                    std::pair("tilt_um", &surface.tilt)}) {
    double value_mm = length->in_mm();
    PANELCAL_CHECK(read_um_in_mm(*table, key, value_mm));
    *length = mm(value_mm);
  }
  return {};
}

}  // namespace panelcal::internal
