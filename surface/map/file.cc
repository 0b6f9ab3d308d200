// SPDX-License-Identifier: Apache-2.0
#include "surface/map/file.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "calib/base/fields/json.h"
#include "calib/base/fields/noted_head.h"
#include "calib/base/fields/slots.h"
#include "calib/base/files/atomic_file.h"
#include "surface/json_files.h"
#include "surface/map/file_parts.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr int kMaxMapInt = std::numeric_limits<int>::max();
/// More spindles than a machine has.
constexpr int kMaxMapAxis = 63;
/// Farther away or higher nothing is probed: a wrong unit.
constexpr Range kInMap = {-3e7, 3e7};

std::string_view kernel_word(BendingKernel kernel) {
  return word(kernel);
}

std::string_view model_word(SurfaceModel model) {
  return word(model);
}

std::string_view interpolation_word(LatticeInterpolation interpolation) {
  return interpolation == LatticeInterpolation::Bilinear ? "bilinear" : "monotone-bicubic";
}

std::optional<LatticeInterpolation> lattice_interpolation(std::string_view word) {
  for (const auto known : {LatticeInterpolation::Bilinear, LatticeInterpolation::MonotoneBicubic}) {
    if (interpolation_word(known) == word) return known;
  }
  return std::nullopt;
}

bool put_circles(MapVoid& element, const FieldValue& value) {
  element.circles = value.numbers;
  return !element.circles.empty();
}

bool get_circles(const MapVoid& element, FieldValue& value) {
  value.numbers = element.circles;
  return !element.circles.empty();
}

#include "surface/map/file.def"

Expected<std::vector<ProbePoint>> points_of(const MapFile& written, const std::string& file) {
  std::vector<ProbePoint> out;
  for (const MapProbe& probe : written.probes) {
    ProbePoint& point = out.emplace_back(probe.point);
    if (!probe.i_source) continue;
    const auto i_source = static_cast<std::size_t>(*probe.i_source);
    if (i_source >= written.sources.size()) {
      return failure(
          map_file_problem(file,
                           fmt::format("the source of probe {} is {}", out.size() - 1, i_source),
                           fmt::format("one of {} sources, from 0", written.sources.size())));
    }
    point.from.file = written.sources[i_source].file;
  }
  return out;
}

/// The declared zones; none if the only one has no area.
Expected<std::vector<Zone>> zones_of(const MapFile& written, const std::string& file) {
  std::vector<Zone> out;
  if (written.zones.empty() || written.zones.size() > kMostZones) {
    return failure(map_file_problem(
        file, fmt::format("{} zones", written.zones.size()), fmt::format("1 to {}", kMostZones)));
  }
  if (written.zones.size() == 1 && !written.zones.front().area) return out;
  for (const MapZone& zone : written.zones) {
    PANELCAL_TRY(Area area,
                 zone_area(zone.area.value_or(MapArea()), "zone " + quoted(zone.name), file));
    out.push_back({std::move(area), zone.name, {}, {file, 0, 0}});
  }
  return out;
}

/// In     surfaces: of each zone
Expected<StoredZones> stored_of(const MapFile& written,
                                std::vector<Zone> zones,
                                Voids voids,
                                std::span<const MapSurface* const> surfaces,
                                const std::string& file) {
  PANELCAL_TRY(auto points, points_of(written, file));
  PANELCAL_TRY(SortedProbes sorted, sort_probes(points, zones, voids));
  std::vector<HeightMap> maps;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    PANELCAL_TRY(HeightMap map, surface_of(*surfaces[i], points, sorted.by_zone[i], file));
    if (i < zones.size()) zones[i].options = map.options();
    maps.push_back(std::move(map));
  }
  return StoredZones{
      std::move(points),
      ZonedMap::of_maps(std::move(zones), std::move(voids), std::move(sorted), std::move(maps)),
      written.sources,
      written.made_by,
      written.z_axis};
}

Expected<StoredZones> read_plain(const nlohmann::json& document, const std::string& file) {
  PANELCAL_TRY(const MapFile written, read_json(kPlainMap, document, kMapFileCode, file));
  return stored_of(written, {}, {}, std::array{&written.surface}, file);
}

Expected<StoredZones> read_zoned(const nlohmann::json& document, const std::string& file) {
  PANELCAL_TRY(const MapFile written, read_json(kZonedMap, document, kMapFileCode, file));
  PANELCAL_TRY(std::vector<Zone> zones, zones_of(written, file));
  PANELCAL_TRY(Voids voids, voids_of(written, file));
  std::vector<const MapSurface*> surfaces;
  for (const MapZone& zone : written.zones) surfaces.push_back(&zone.surface);
  return stored_of(written, std::move(zones), std::move(voids), surfaces, file);
}

/// All but the surfaces.
template <class Stored>
MapFile written_head(const Stored& stored) {
  MapFile out;
  out.made_by = stored.made_by;
  out.z_axis = stored.z_axis;
  out.sources = stored.sources;
  for (const ProbePoint& point : stored.points) {
    const auto source = std::ranges::find(stored.sources, point.from.file, &MapSource::file);
    out.probes.push_back({point, std::nullopt});
    if (source == stored.sources.end()) continue;
    out.probes.back().i_source = static_cast<int>(source - stored.sources.begin());
  }
  return out;
}

std::string zoned_text(const StoredZones& stored) {
  MapFile out = written_head(stored);
  const std::span<const Zone> zones = stored.map.zones();
  for (std::size_t i = 0; i < stored.map.maps().size(); ++i) {
    MapZone& zone = out.zones.emplace_back();
    if (i < zones.size()) {
      zone.name = zones[i].name;
      zone.area = written_area(zones[i].area);
    }
    zone.surface = written_surface(stored.map.map(i), stored.map.probes(i));
  }
  out.margin = stored.map.voids().margin();
  out.voids = written_voids(stored.map.voids().all());
  return json_text(kZonedMap, out, JsonStyle::File);
}

}  // namespace

JsonFile surface_map_file() {
  return {"surface-map.json",
          "A map of heights: `panelcal surface fit` writes it, version 2 with zones or voids. "
          "Nothing is chosen or searched again when it is read, so that heights and sigmas are the "
          "same to the bit.",
          {&kPlainMap, &kZonedMap},
          true};
}

}  // namespace panelcal::internal

namespace panelcal {

StoredMap StoredZones::zone(std::size_t i_zone) const {
  std::vector<ProbePoint> own;
  for (const std::size_t i : map.probes(i_zone)) own.push_back(points[i]);
  return {std::move(own), map.map(i_zone), sources, made_by, z_axis};
}

Expected<StoredZones> parse_zoned_map_file(std::string_view text, const std::string& file) {
  PANELCAL_TRY(const nlohmann::json document, internal::parse_calibration_json(text, file));
  // Keys of a version that is not known would be called unknown.
  const bool has_version = document.is_object() && document.contains("version");
  if (!has_version || document["version"] == 1) return internal::read_plain(document, file);
  if (document["version"] == 2) return internal::read_zoned(document, file);
  return failure(internal::map_file_problem(
      file, "the version is " + quoted(document["version"].dump()), "1 or 2"));
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
  internal::MapFile out = internal::written_head(stored);
  out.surface = internal::written_surface(stored.map, all);
  return internal::json_text(internal::kPlainMap, out, internal::JsonStyle::File);
}

std::string map_file_text(const StoredZones& stored) {
  const bool is_plain = stored.map.zones().empty() && stored.map.voids().all().empty();
  return is_plain ? map_file_text(stored.zone(0)) : internal::zoned_text(stored);
}

}  // namespace panelcal
