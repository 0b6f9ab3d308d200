// SPDX-License-Identifier: Apache-2.0
#include "machine/config/zones_file.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "calib/base/fields/slots.h"
#include "calib/base/files/atomic_file.h"
#include "machine/config/toml/toml_table.h"
#include "surface/fit/shape.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::count;
using internal::field;
using internal::Field;
using internal::FileDescription;
using internal::joined;
using internal::Range;
using internal::Rows;
using internal::Table;
using internal::TableDescription;
using internal::TomlSource;
using internal::TomlTable;

/// As check_area() has it; here the message shows the number.
constexpr Range kPlace_mm{-1e6, 1e6};
constexpr Range kSize_mm{0, 1e6, true};

/// A zone, a void or the panel: corners are one list, as the dots of a template are written.
struct ZoneKeys {
  std::string name;
  std::vector<double> rectangle_mm;
  std::vector<double> polygon_mm;
  std::vector<double> track_mm;
  Position<frame::Nominal> center;
  std::optional<Length> diameter;
  std::optional<Length> width;
  std::optional<Length> max_extrapolation;
  std::string model;
};

#include "machine/config/zones_file.def"

using Corners = std::vector<Position<frame::Nominal>>;

Expected<Corners> corners_of(const TomlTable& table,
                             std::string_view key,
                             const std::vector<double>& all_mm) {
  if (all_mm.size() % 2 != 0) {
    return failure(table.problem(key, "pairs: [x1, y1, x2, y2, ...]", "a number without another"));
  }
  Corners out;
  for (std::size_t i = 0; i < all_mm.size(); i += 2) {
    out.push_back(position_mm<frame::Nominal>(all_mm[i], all_mm[i + 1]));
  }
  return out;
}

Expected<Area> rectangle_of(const TomlTable& table, const std::vector<double>& side_mm) {
  if (side_mm.size() != 4 || !(side_mm[0] < side_mm[2]) || !(side_mm[1] < side_mm[3])) {
    return failure(
        table.problem("rectangle_mm", "[x0, y0, x1, y1] with x0 below x1 and y0 below y1"));
  }
  return rectangle(position_mm<frame::Nominal>(side_mm[0], side_mm[1]),
                   position_mm<frame::Nominal>(side_mm[2], side_mm[3]));
}

/// A number without which another key says nothing.
Expected<Length> needed_size(const TomlTable& table,
                             std::string_view key,
                             std::string_view of,
                             const std::optional<Length>& size) {
  if (size) return *size;
  return failure(table.missing(key, fmt::format("{} = 3, beside {}", key, of)));
}

/// Precondition: the table has the key.
Expected<Area> zone_shape(const TomlTable& table, std::string_view key, const ZoneKeys& keys) {
  if (key == "rectangle_mm") return rectangle_of(table, keys.rectangle_mm);
  if (key == "center_mm") {
    PANELCAL_TRY(const Length diameter, needed_size(table, "diameter_mm", key, keys.diameter));
    return Circle{keys.center, 0.5 * diameter};
  }
  const bool is_polygon = key == "polygon_mm";
  PANELCAL_TRY(Corners corners,
               corners_of(table, key, is_polygon ? keys.polygon_mm : keys.track_mm));
  if (is_polygon) return Polygon{std::move(corners)};
  PANELCAL_TRY(const Length width, needed_size(table, "width_mm", key, keys.width));
  return Track{std::move(corners), width};
}

constexpr std::array<std::string_view, 4> kAreaKeys = {
    "rectangle_mm", "polygon_mm", "center_mm", "track_mm"};
/// Keys that say how large the area of another key is.
constexpr std::array<std::pair<std::string_view, std::string_view>, 2> kSizes = {
    {{"diameter_mm", "center_mm"}, {"width_mm", "track_mm"}}};

/// The one area that a table says.
///
/// In     areas: those that the table may have, for messages
Expected<Area> read_area(const TomlTable& table,
                         const ZoneKeys& keys,
                         const std::string& name,
                         std::string_view areas) {
  std::string_view found;
  for (const std::string_view key : kAreaKeys) {
    if (!table.has(key)) continue;
    if (!found.empty()) {
      return failure(table.problem(key, "one area", fmt::format("there is {} already", found)));
    }
    found = key;
  }
  if (found.empty()) return failure(table.missing("area", "one of " + std::string(areas)));
  for (const auto& [size, of] : kSizes) {
    if (table.has(size) && found != of) {
      return failure(table.problem(size, fmt::format("none without {}", of)));
    }
  }
  PANELCAL_TRY(Area area, zone_shape(table, found, keys));
  PANELCAL_CHECK(check_area(area, name, table.place_of(found)));
  return area;
}

Expected<Zone> read_zone(const TomlTable& table, const HeightMapOptions& defaults) {
  ZoneKeys keys;
  PANELCAL_CHECK(table.read(kZone, keys));
  Zone zone;
  zone.options = defaults;
  zone.name = keys.name;
  zone.from = table.place_of("name");
  PANELCAL_TRY(zone.area,
               read_area(table, keys, "zone " + keys.name, "rectangle_mm, polygon_mm, center_mm"));
  zone.options.max_extrapolation = keys.max_extrapolation.value_or(defaults.max_extrapolation);
  if (!table.has("model")) return zone;
  zone.options.model = surface_model(keys.model);
  if (zone.options.model || keys.model == "auto") return zone;
  return failure(
      table.problem("model", fmt::format("auto, {}", fmt::join(surface_model_words(), ", "))));
}

Expected<Void> read_void(const TomlTable& table) {
  ZoneKeys keys;
  PANELCAL_CHECK(table.read(kVoid, keys));
  Void out;
  out.name = keys.name;
  out.from = table.place_of("name");
  PANELCAL_TRY(out.area,
               read_area(table, keys, keys.name, "rectangle_mm, polygon_mm, center_mm, track_mm"));
  return out;
}

Expected<Void> read_panel(const TomlTable& table) {
  ZoneKeys keys;
  PANELCAL_CHECK(table.read(kPanel, keys));
  PANELCAL_TRY(const Area inside, read_area(table, keys, "the panel", "polygon_mm, rectangle_mm"));
  return Void{Outside{std::get<Polygon>(inside)},
              "beyond the panel's edge",
              table.place_of(table.has("polygon_mm") ? "polygon_mm" : "rectangle_mm")};
}

}  // namespace

Expected<ZonesFile> parse_zones_file(std::string_view text,
                                     const std::filesystem::path& file,
                                     const HeightMapOptions& defaults) {
  const TomlSource source{file.string(), text};
  const FileDescription description{"the file", {&kZonesFile, &kZone, &kVoid, &kPanel}};
  PANELCAL_TRY(const toml::table document, internal::parse_toml(source));
  PANELCAL_TRY(const TomlTable top, TomlTable::of_file(document, description, source));
  ZonesFile out;
  PANELCAL_CHECK(top.read(kZonesFile, out));
  PANELCAL_TRY(const auto zones, top.tables(kZone));
  for (const TomlTable& table : zones) {
    PANELCAL_TRY(Zone zone, read_zone(table, defaults));
    if (std::ranges::find(out.zones, zone.name, &Zone::name) != out.zones.end()) {
      return failure(table.problem("name", "a name of its own", "another zone has it"));
    }
    out.zones.push_back(std::move(zone));
  }
  PANELCAL_TRY(const auto voids, top.tables(kVoid));
  for (const TomlTable& table : voids) {
    PANELCAL_TRY(out.voids.emplace_back(), read_void(table));
  }
  PANELCAL_TRY(const auto panel, top.table(kPanel));
  if (!panel) return out;
  PANELCAL_TRY(out.voids.emplace_back(), read_panel(*panel));
  return out;
}

Expected<ZonesFile> read_zones_file(const std::filesystem::path& path,
                                    const HeightMapOptions& defaults) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxZonesBytes));
  return parse_zones_file(text, path, defaults);
}

}  // namespace panelcal
