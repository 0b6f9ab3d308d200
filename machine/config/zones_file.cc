// SPDX-License-Identifier: Apache-2.0
#include "machine/config/zones_file.h"

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "machine/config/toml/toml_table.h"
#include "surface/fit/shape.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::Range;
using internal::TomlSource;
using internal::TomlTable;

constexpr std::array<std::string_view, 4> kZonesFileKeys = {
    "panel", "probe_tip_mm", "void", "zone"};
constexpr std::array<std::string_view, 2> kPanelKeys = {"polygon_mm", "rectangle_mm"};
constexpr std::array<std::string_view, 7> kZoneKeys = {"center_mm",
                                                       "diameter_mm",
                                                       "max_extrapolation_mm",
                                                       "model",
                                                       "name",
                                                       "polygon_mm",
                                                       "rectangle_mm"};
constexpr std::array<std::string_view, 7> kVoidKeys = {
    "center_mm", "diameter_mm", "name", "polygon_mm", "rectangle_mm", "track_mm", "width_mm"};
/// As check_area() has it; here the message shows the number.
constexpr Range kPlace_mm{-1e6, 1e6};
constexpr Range kSize_mm{0, 1e6, true};

using Corners = std::vector<Position<frame::Nominal>>;

/// Corners as one list, as the dots of a template are written.
Expected<Corners> read_corners(const TomlTable& table, std::string_view key) {
  PANELCAL_TRY(const auto read_mm, table.numbers(key, kPlace_mm));
  const std::vector<double> all_mm = read_mm.value_or(std::vector<double>());
  if (all_mm.size() % 2 != 0) {
    return failure(table.problem(key, "pairs: [x1, y1, x2, y2, ...]", "a number without another"));
  }
  Corners out;
  for (std::size_t i = 0; i < all_mm.size(); i += 2) {
    out.push_back(position_mm<frame::Nominal>(all_mm[i], all_mm[i + 1]));
  }
  return out;
}

/// Precondition: the table has the key.
Place place_of(const TomlTable& table, std::string_view key) {
  return table.problem(key, "").place;
}

Expected<Area> read_rectangle(const TomlTable& table) {
  PANELCAL_TRY(const auto read_mm, table.numbers("rectangle_mm", kPlace_mm));
  const std::vector<double> side_mm = read_mm.value_or(std::vector<double>());
  if (side_mm.size() != 4 || !(side_mm[0] < side_mm[2]) || !(side_mm[1] < side_mm[3])) {
    return failure(
        table.problem("rectangle_mm", "[x0, y0, x1, y1] with x0 below x1 and y0 below y1"));
  }
  return rectangle(position_mm<frame::Nominal>(side_mm[0], side_mm[1]),
                   position_mm<frame::Nominal>(side_mm[2], side_mm[3]));
}

/// A number without which another key says nothing.
Expected<Length> needed_size(const TomlTable& table, std::string_view key, std::string_view of) {
  PANELCAL_TRY(const auto size_mm, table.number(key, kSize_mm));
  if (size_mm) return mm(*size_mm);
  return failure(table.missing(key, fmt::format("{} = 3, beside {}", key, of)));
}

/// Precondition: the table has the key.
Expected<Area> read_zone_shape(const TomlTable& table, std::string_view key) {
  if (key == "rectangle_mm") return read_rectangle(table);
  if (key == "center_mm") {
    PANELCAL_TRY(const auto center_mm, table.pair(key, kPlace_mm));
    PANELCAL_TRY(const Length diameter, needed_size(table, "diameter_mm", key));
    return Circle{position_mm<frame::Nominal>(center_mm.value_or(Eigen::Vector2d::Zero())),
                  0.5 * diameter};
  }
  PANELCAL_TRY(Corners corners, read_corners(table, key));
  if (key == "polygon_mm") return Polygon{std::move(corners)};
  PANELCAL_TRY(const Length width, needed_size(table, "width_mm", key));
  return Track{std::move(corners), width};
}

/// Keys that say how large the area of another key is.
constexpr std::array<std::pair<std::string_view, std::string_view>, 2> kSizes = {
    {{"diameter_mm", "center_mm"}, {"width_mm", "track_mm"}}};

/// The one area that a table says.
///
/// In     keys: that begin one, of those the table may have
Expected<Area> read_area(const TomlTable& table,
                         std::span<const std::string_view> keys,
                         const std::string& name) {
  std::string_view found;
  for (const std::string_view key : keys) {
    if (!table.has(key)) continue;
    if (!found.empty()) {
      return failure(table.problem(key, "one area", fmt::format("there is {} already", found)));
    }
    found = key;
  }
  if (found.empty()) {
    return failure(table.missing("area", fmt::format("one of {}", fmt::join(keys, ", "))));
  }
  for (const auto& [size, of] : kSizes) {
    if (table.has(size) && found != of) {
      return failure(table.problem(size, fmt::format("none without {}", of)));
    }
  }
  PANELCAL_TRY(Area area, read_zone_shape(table, found));
  PANELCAL_CHECK(check_area(area, name, place_of(table, found)));
  return area;
}

Expected<std::string> read_name(const TomlTable& table) {
  PANELCAL_TRY(const auto name, table.text("name"));
  if (!name) return failure(table.missing("name", "name = \"left\""));
  if (name->empty()) return failure(table.problem("name", "a name"));
  return *name;
}

Expected<Zone> read_zone(const TomlTable& table, const HeightMapOptions& defaults) {
  constexpr std::array<std::string_view, 3> kAreas = {"rectangle_mm", "polygon_mm", "center_mm"};
  Zone zone;
  zone.options = defaults;
  PANELCAL_TRY(const std::string name, read_name(table));
  zone.name = name;
  zone.from = place_of(table, "name");
  PANELCAL_TRY(zone.area, read_area(table, kAreas, "zone " + name));
  PANELCAL_TRY(
      const double most_mm,
      table.number_or("max_extrapolation_mm", {0, 1000}, defaults.max_extrapolation.in_mm()));
  zone.options.max_extrapolation = mm(most_mm);
  PANELCAL_TRY(const auto word, table.text("model"));
  if (!word) return zone;
  zone.options.model = surface_model(*word);
  if (zone.options.model || *word == "auto") return zone;
  return failure(
      table.problem("model", fmt::format("auto, {}", fmt::join(surface_model_words(), ", "))));
}

Expected<Void> read_void(const TomlTable& table) {
  constexpr std::array<std::string_view, 4> kAreas = {
      "rectangle_mm", "polygon_mm", "center_mm", "track_mm"};
  Void out;
  PANELCAL_TRY(const std::string name, read_name(table));
  out.name = name;
  out.from = place_of(table, "name");
  PANELCAL_TRY(out.area, read_area(table, kAreas, name));
  return out;
}

}  // namespace

Expected<ZonesFile> parse_zones_file(std::string_view text,
                                     const std::filesystem::path& file,
                                     const HeightMapOptions& defaults) {
  const TomlSource source{file.string(), text};
  PANELCAL_TRY(const toml::table document, internal::parse_toml(source));
  PANELCAL_TRY(
      const TomlTable top,
      TomlTable::make(document, "the file", document.source(), {kZonesFileKeys, {}}, source));
  ZonesFile out;
  PANELCAL_TRY(const auto tip_mm, top.number("probe_tip_mm", {0, 100, true}));
  if (tip_mm) out.probe_tip = mm(*tip_mm);
  PANELCAL_TRY(const auto zones, top.tables("zone", "[[zone]]", {kZoneKeys, {}}));
  for (const TomlTable& table : zones) {
    PANELCAL_TRY(Zone zone, read_zone(table, defaults));
    if (std::ranges::find(out.zones, zone.name, &Zone::name) != out.zones.end()) {
      return failure(table.problem("name", "a name of its own", "another zone has it"));
    }
    out.zones.push_back(std::move(zone));
  }
  PANELCAL_TRY(const auto voids, top.tables("void", "[[void]]", {kVoidKeys, {}}));
  for (const TomlTable& table : voids) {
    PANELCAL_TRY(Void one, read_void(table));
    out.voids.push_back(std::move(one));
  }
  PANELCAL_TRY(const auto panel, top.table("panel", "[panel]", {kPanelKeys, {}}));
  if (!panel) return out;
  const std::string name = "beyond the panel's edge";
  PANELCAL_TRY(const Area inside, read_area(*panel, kPanelKeys, "the panel"));
  out.voids.push_back({Outside{std::get<Polygon>(inside)},
                       name,
                       place_of(*panel, panel->has("polygon_mm") ? "polygon_mm" : "rectangle_mm")});
  return out;
}

Expected<ZonesFile> read_zones_file(const std::filesystem::path& path,
                                    const HeightMapOptions& defaults) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxZonesBytes));
  return parse_zones_file(text, path, defaults);
}

}  // namespace panelcal
