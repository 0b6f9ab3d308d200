// SPDX-License-Identifier: Apache-2.0
#include "panelcal/surface/zoned_map.h"

#include <algorithm>
#include <set>
#include <string_view>

#include <fmt/format.h>

#include "panelcal/surface/surface_outliers.h"

namespace panelcal {
namespace {

Expected<void> check_zones(std::span<const Zone> zones) {
  std::set<std::string_view> names;
  for (const Zone& zone : zones) {
    PANELCAL_CHECK(check_area(zone.area, zone.name, zone.from));
    if (names.insert(zone.name).second) continue;
    return failure(
        {Code::ConfigValue, zone.from, "a second zone " + quoted(zone.name), "a name of its own"});
  }
  return {};
}

/// The same diagnostic with the zone's name before it.
Diagnostic of_zone(const Zone& zone, Diagnostic diagnostic) {
  diagnostic.what = fmt::format("zone {}: {}", quoted(zone.name), diagnostic.what);
  return diagnostic;
}

}  // namespace

struct ZonedMap::State {
  std::vector<Zone> zones;  ///< empty: one map all over the table
  Voids voids;
  std::vector<HeightMap> maps;
  std::vector<UnusedProbe> unused;

  /// The first zone that holds a place; empty if none does.
  std::optional<std::size_t> zone_at(const Position<frame::Nominal>& place) const {
    if (zones.empty()) return 0;
    for (std::size_t i = 0; i < zones.size(); ++i) {
      if (is_within(zones[i].area, place)) return i;
    }
    return std::nullopt;
  }
};

Expected<ZonedMap> ZonedMap::of_probes(std::span<const ProbePoint> points,
                                       std::vector<Zone> zones,
                                       Voids voids,
                                       const HeightMapOptions& without_zones) {
  PANELCAL_CHECK(check_zones(zones));
  State state;
  state.zones = std::move(zones);
  state.voids = std::move(voids);
  std::vector<std::vector<ProbePoint>> by_zone(std::max<std::size_t>(1, state.zones.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::optional<std::size_t> zone = state.zone_at(points[i].place);
    const Void* const hole = state.voids.at(points[i].place);
    if (hole != nullptr) {
      state.unused.push_back(
          {i, fmt::format("{} lies in {}", name_of(points[i]), quoted(hole->name))});
    } else if (!zone) {
      state.unused.push_back({i, fmt::format("{} lies in no zone", name_of(points[i]))});
    } else {
      by_zone[*zone].push_back(points[i]);
    }
  }
  for (std::size_t i = 0; i < by_zone.size(); ++i) {
    if (state.zones.empty()) {
      PANELCAL_TRY(HeightMap map, HeightMap::of_probes(by_zone[i], without_zones));
      state.maps.push_back(std::move(map));
      continue;
    }
    const Zone& zone = state.zones[i];
    auto map = HeightMap::of_probes(by_zone[i], zone.options);
    if (!map) return failure(of_zone(zone, std::move(map).error()));
    state.maps.push_back(*std::move(map));
  }
  return ZonedMap(std::make_shared<const State>(std::move(state)));
}

Expected<ZonedHeight> ZonedMap::height_at(const Position<frame::Nominal>& place) const {
  const std::optional<std::size_t> zone = state_->zone_at(place);
  if (!zone) {
    return failure(
        {Code::GridInvalid,
         {},
         fmt::format("({:.3f}, {:.3f}) lies in no zone", place.in_mm().x(), place.in_mm().y()),
         fmt::format("a place in one of {} zones", state_->zones.size())});
  }
  auto height = state_->maps[*zone].height_at(place);
  if (!height) {
    if (state_->zones.empty()) return failure(std::move(height).error());
    return failure(of_zone(state_->zones[*zone], std::move(height).error()));
  }
  ZonedHeight out{*height, *zone, {}};
  if (const Void* const hole = state_->voids.at(place)) {
    out.height.source = HeightSource::InVoid;
    out.void_name = hole->name;
  }
  return out;
}

std::span<const Zone> ZonedMap::zones() const {
  return state_->zones;
}

const HeightMap& ZonedMap::map(std::size_t i_zone) const {
  return state_->maps[i_zone];
}

std::span<const UnusedProbe> ZonedMap::unused() const {
  return state_->unused;
}

}  // namespace panelcal
