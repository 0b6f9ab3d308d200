// SPDX-License-Identifier: Apache-2.0
#include "surface/map/file.h"

#include <array>
#include <numeric>
#include <optional>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/json/noted_head.h"
#include "calib/base/json/strict_json.h"
#include "surface/map/file_surface.h"
#include "surface/map/file_voids.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::kMapFileCode;
using internal::map_file_problem;
using internal::StrictObject;
using nlohmann::json;

constexpr std::string_view kKind = "surface-map";
constexpr int kPlain = 1;  ///< the version of a map without zones and voids
constexpr int kZoned = 2;

/// More spindles than a machine has.
constexpr int kMaxMapAxis = 63;

/// The members of a map, with `zaxis` where it is stated.
template <std::size_t n>
Expected<StrictObject> map_members(const json& document,
                                   const std::array<std::string_view, n>& required,
                                   const std::string& file) {
  std::vector<std::string_view> keys(required.begin(), required.end());
  if (document.is_object() && document.contains("zaxis")) keys.emplace_back("zaxis");
  return StrictObject::make(document, "the map", keys, kMapFileCode, file);
}

Expected<std::optional<int>> read_axis(const StrictObject& top, const json& document) {
  if (!document.contains("zaxis")) return std::nullopt;
  PANELCAL_TRY(const int z_axis, top.integer("zaxis", 0, kMaxMapAxis));
  return z_axis;
}

Expected<void> check_head(const StrictObject& top, int version) {
  PANELCAL_CHECK(top.constant("kind", kKind));
  PANELCAL_CHECK(top.integer("version", version, version));
  return top.constant("units", "mm");
}

Expected<StoredZones> read_plain(const json& document, const std::string& file) {
  constexpr std::array<std::string_view, 11> kKeys = {"kind",
                                                      "version",
                                                      "made_by",
                                                      "units",
                                                      "model",
                                                      "reason",
                                                      "shape",
                                                      "options",
                                                      "sources",
                                                      "left_out",
                                                      "probes"};
  PANELCAL_TRY(const StrictObject top, map_members(document, kKeys, file));
  PANELCAL_CHECK(check_head(top, kPlain));
  PANELCAL_TRY(const std::optional<int> z_axis, read_axis(top, document));
  PANELCAL_TRY(std::string made_by, top.text("made_by"));
  PANELCAL_TRY(auto sources, internal::read_sources(top, file));
  PANELCAL_TRY(auto points, internal::read_probes(top, sources, file));
  PANELCAL_TRY(SortedProbes sorted, sort_probes(points, {}, {}));
  PANELCAL_TRY(HeightMap map, internal::read_surface(top, points, sorted.by_zone[0], file));
  return StoredZones{std::move(points),
                     ZonedMap::of_maps({}, {}, std::move(sorted), {std::move(map)}),
                     std::move(sources),
                     std::move(made_by),
                     z_axis};
}

/// The declared zones; none if the only one has no area.
Expected<std::vector<Zone>> read_zones(std::span<const StrictObject> objects,
                                       const std::string& file) {
  std::vector<Zone> out;
  for (const StrictObject& object : objects) {
    Zone zone;
    PANELCAL_TRY(const std::string name, object.text("name"));
    if (object.member("area").is_null() && objects.size() == 1) return out;
    PANELCAL_TRY(zone.area,
                 internal::read_zone_area(
                     object.member("area"), fmt::format("zone {}", quoted(name)), file));
    zone.name = name;
    zone.from.file = file;
    out.push_back(std::move(zone));
  }
  return out;
}

Expected<StoredZones> read_zoned(const json& document, const std::string& file) {
  constexpr std::array<std::string_view, 9> kKeys = {
      "kind", "version", "made_by", "units", "zones", "margin", "voids", "sources", "probes"};
  constexpr std::array<std::string_view, 7> kZoneKeys = {
      "name", "area", "model", "reason", "shape", "options", "left_out"};
  PANELCAL_TRY(const StrictObject top, map_members(document, kKeys, file));
  PANELCAL_CHECK(check_head(top, kZoned));
  PANELCAL_TRY(const std::optional<int> z_axis, read_axis(top, document));
  PANELCAL_TRY(std::string made_by, top.text("made_by"));
  PANELCAL_TRY(const auto objects, internal::read_objects(top, "zones", "zone", kZoneKeys, file));
  if (objects.empty() || objects.size() > kMostZones) {
    return failure(map_file_problem(
        file, fmt::format("{} zones", objects.size()), fmt::format("1 to {}", kMostZones)));
  }
  PANELCAL_TRY(std::vector<Zone> zones, read_zones(objects, file));
  PANELCAL_TRY(Voids voids, internal::read_voids(top, file));
  PANELCAL_TRY(auto sources, internal::read_sources(top, file));
  PANELCAL_TRY(auto points, internal::read_probes(top, sources, file));
  PANELCAL_TRY(SortedProbes sorted, sort_probes(points, zones, voids));
  std::vector<HeightMap> maps;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    PANELCAL_TRY(HeightMap map,
                 internal::read_surface(objects[i], points, sorted.by_zone[i], file));
    if (i < zones.size()) zones[i].options = map.options();
    maps.push_back(std::move(map));
  }
  return StoredZones{
      std::move(points),
      ZonedMap::of_maps(std::move(zones), std::move(voids), std::move(sorted), std::move(maps)),
      std::move(sources),
      std::move(made_by),
      z_axis};
}

template <class Stored>
std::string head_text(int version, const Stored& stored) {
  return fmt::format(
      "{{\n  \"kind\": \"{}\",\n  \"version\": {},\n  \"made_by\": {},\n  \"units\": \"mm\",\n{}",
      kKind,
      version,
      internal::json_text(stored.made_by),
      stored.z_axis ? fmt::format("  \"zaxis\": {},\n", *stored.z_axis) : "");
}

std::string zone_text(const ZonedMap& map, std::size_t i_zone) {
  const bool is_declared = i_zone < map.zones().size();
  return fmt::format(
      "    {{\n      \"name\": {},\n      \"area\": {},\n{},\n{}\n    }}",
      internal::json_text(is_declared ? map.zones()[i_zone].name : ""),
      is_declared ? internal::area_text(map.zones()[i_zone].area) : "null",
      internal::surface_text(map.map(i_zone), "      "),
      internal::list_text(
          "left_out", internal::left_out_texts(map.map(i_zone), map.probes(i_zone)), "      "));
}

std::string zoned_text(const StoredZones& stored) {
  std::vector<std::string> zones;
  for (std::size_t i = 0; i < stored.map.maps().size(); ++i) {
    zones.push_back(zone_text(stored.map, i));
  }
  return fmt::format(
      "{}  \"zones\": [\n{}\n  ],\n  \"margin\": {},\n{},\n{},\n{}\n}}\n",
      head_text(kZoned, stored),
      fmt::join(zones, ",\n"),
      stored.map.voids().margin().in_mm(),
      internal::list_text("voids", internal::void_texts(stored.map.voids().all()), "  "),
      internal::list_text("sources", internal::source_texts(stored.sources), "  "),
      internal::list_text("probes", internal::probe_texts(stored.points, stored.sources), "  "));
}

}  // namespace

StoredMap StoredZones::zone(std::size_t i_zone) const {
  std::vector<ProbePoint> own;
  for (const std::size_t i : map.probes(i_zone)) own.push_back(points[i]);
  return {std::move(own), map.map(i_zone), sources, made_by, z_axis};
}

Expected<StoredZones> parse_zoned_map_file(std::string_view text, const std::string& file) {
  PANELCAL_TRY(const json document, internal::parse_calibration_json(text, file));
  // Keys of a version that is not known would be called unknown.
  const bool has_version = document.is_object() && document.contains("version");
  if (!has_version || document["version"] == kPlain) return read_plain(document, file);
  if (document["version"] == kZoned) return read_zoned(document, file);
  return failure(map_file_problem(file,
                                  "the version is " + quoted(document["version"].dump()),
                                  fmt::format("{} or {}", kPlain, kZoned)));
}

Expected<StoredZones> read_zoned_map_file(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxMapBytes));
  return parse_zoned_map_file(text, path.string());
}

Expected<StoredMap> parse_map_file(std::string_view text, const std::string& file) {
  PANELCAL_TRY(const StoredZones stored, parse_zoned_map_file(text, file));
  if (stored.map.zones().empty() && stored.map.voids().all().empty()) return stored.zone(0);
  return failure({Code::NotSupported,
                  {file, 0, 0},
                  fmt::format("a map of {} zones and {} voids",
                              stored.map.zones().size(),
                              stored.map.voids().all().size()),
                  "a map without them"});
}

std::vector<ProbePoint> StoredMap::kept_points() const {
  std::vector<ProbePoint> out;
  for (const std::size_t i : map.kept()) out.push_back(points[i]);
  return out;
}

Expected<StoredMap> read_map_file(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxMapBytes));
  return parse_map_file(text, path.string());
}

std::string map_file_text(const StoredMap& stored) {
  std::vector<std::size_t> all(stored.points.size());
  std::iota(all.begin(), all.end(), 0);
  return fmt::format(
      "{}{},\n{},\n{},\n{}\n}}\n",
      head_text(kPlain, stored),
      internal::surface_text(stored.map, "  "),
      internal::list_text("sources", internal::source_texts(stored.sources), "  "),
      internal::list_text("left_out", internal::left_out_texts(stored.map, all), "  "),
      internal::list_text("probes", internal::probe_texts(stored.points, stored.sources), "  "));
}

std::string map_file_text(const StoredZones& stored) {
  const bool is_plain = stored.map.zones().empty() && stored.map.voids().all().empty();
  return is_plain ? map_file_text(stored.zone(0)) : zoned_text(stored);
}

}  // namespace panelcal
