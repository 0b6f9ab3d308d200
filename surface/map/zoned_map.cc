// SPDX-License-Identifier: Apache-2.0
#include "surface/map/zoned_map.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>
#include <string_view>

#include "surface/fit/outliers.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

Expected<void> check_zones(std::span<const Zone> zones) {
  if (zones.size() > kMostZones) {
    return failure({Code::ConfigValue,
                    zones.back().from,
                    fmt::format("{} zones", zones.size()),
                    fmt::format("at most {}", kMostZones)});
  }
  std::set<std::string_view> names;
  for (const Zone& zone : zones) {
    PANELCAL_CHECK(check_area(zone.area, zone.name, zone.from));
    if (names.insert(zone.name).second) continue;
    return failure(
        {Code::ConfigValue, zone.from, "a second zone " + quoted(zone.name), "a name of its own"});
  }
  return {};
}

/// The same diagnostic with the zone's name before it, and its place if there is no other.
Diagnostic of_zone(const Zone& zone, Diagnostic diagnostic) {
  diagnostic.what = fmt::format("zone {}: {}", quoted(zone.name), diagnostic.what);
  if (diagnostic.place.file.empty()) diagnostic.place = zone.from;
  return diagnostic;
}

std::optional<std::size_t> first_zone(std::span<const Zone> zones,
                                      const Position<frame::Nominal>& place) {
  if (zones.empty()) return 0;
  for (std::size_t i = 0; i < zones.size(); ++i) {
    if (is_within(zones[i].area, place)) return i;
  }
  return std::nullopt;
}

Diagnostic in_no_zone(const Position<frame::Nominal>& place, std::size_t n_zones) {
  return {Code::GridInvalid,
          {},
          fmt::format("({:.3f}, {:.3f}) lies in no zone", place.in_mm().x(), place.in_mm().y()),
          fmt::format("a place in {}",
                      n_zones == 1 ? "the zone" : fmt::format("one of {} zones", n_zones))};
}

}  // namespace

Expected<SortedProbes> sort_probes(std::span<const ProbePoint> points,
                                   std::span<const Zone> zones,
                                   const Voids& voids) {
  PANELCAL_CHECK(check_zones(zones));
  SortedProbes out;
  out.by_zone.resize(std::max<std::size_t>(1, zones.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::optional<std::size_t> zone = first_zone(zones, points[i].place);
    if (!zone) {
      out.unused.push_back({i, "it lies in no zone"});
    } else if (const Void* const hole = voids.touched_at(points[i].place)) {
      const bool is_inside = is_within(hole->area, points[i].place);
      out.unused.push_back({i, (is_inside ? "it lies in " : "it may touch ") + text_of(*hole)});
    } else {
      out.by_zone[*zone].push_back(i);
    }
  }
  return out;
}

struct ZonedMap::State {
  std::vector<Zone> zones;  ///< empty: one map all over the table
  Voids voids;
  SortedProbes sorted;
  std::vector<HeightMap> maps;

  /// The same diagnostic with the zone's name, if it has one.
  Diagnostic of_zone(std::size_t i_zone, Diagnostic diagnostic) const {
    return zones.empty() ? diagnostic : panelcal::of_zone(zones[i_zone], std::move(diagnostic));
  }
};

Expected<ZonedMap> ZonedMap::of_probes(std::span<const ProbePoint> points,
                                       std::vector<Zone> zones,
                                       Voids voids,
                                       const HeightMapOptions& without_zones) {
  PANELCAL_TRY(SortedProbes sorted, sort_probes(points, zones, voids));
  std::vector<HeightMap> maps;
  for (std::size_t i = 0; i < sorted.by_zone.size(); ++i) {
    std::vector<ProbePoint> own;
    for (const std::size_t k : sorted.by_zone[i]) own.push_back(points[k]);
    auto map = HeightMap::of_probes(own, zones.empty() ? without_zones : zones[i].options);
    if (!map) {
      return failure(zones.empty() ? std::move(map).error()
                                   : of_zone(zones[i], std::move(map).error()));
    }
    maps.push_back(*std::move(map));
  }
  return of_maps(std::move(zones), std::move(voids), std::move(sorted), std::move(maps));
}

ZonedMap::ZonedMap(HeightMap map) {
  SortedProbes sorted{{{}}, {}};
  sorted.by_zone[0].resize(map.kept().size() + map.outliers().size());
  std::iota(sorted.by_zone[0].begin(), sorted.by_zone[0].end(), 0);
  *this = of_maps({}, {}, std::move(sorted), {std::move(map)});
}

Length ZonedMap::finest_cell() const {
  double least_mm = std::numeric_limits<double>::infinity();
  for (const HeightMap& map : maps()) {
    least_mm = std::min({least_mm, map.lattice().x().step_mm, map.lattice().y().step_mm});
  }
  return mm(least_mm);
}

std::optional<ZoneStep> ZonedMap::step_between(const Position<frame::Nominal>& from,
                                               const Position<frame::Nominal>& to) const {
  if (zones().size() < 2) return std::nullopt;
  const auto zone = zone_at(from), next = zone_at(to);
  if (!zone || !next || zone == next) return std::nullopt;
  // At one place, if the first zone's map reaches so far: else at the two beside the border.
  auto before = map(*zone).height_at(to);
  if (!before) before = map(*zone).height_at(from);
  const auto after = map(*next).height_at(to);
  if (!before || !after) return std::nullopt;
  return ZoneStep{after->height - before->height, *zone, *next};
}

ZonedMap ZonedMap::of_maps(std::vector<Zone> zones,
                           Voids voids,
                           SortedProbes sorted,
                           std::vector<HeightMap> maps) {
  return ZonedMap(std::make_shared<const State>(
      State{std::move(zones), std::move(voids), std::move(sorted), std::move(maps)}));
}

Expected<ZonedHeight> ZonedMap::height_at(const Position<frame::Nominal>& place) const {
  const std::optional<std::size_t> zone = zone_at(place);
  if (!zone) return failure(in_no_zone(place, state_->zones.size()));
  auto height = state_->maps[*zone].height_at(place);
  if (!height) return failure(state_->of_zone(*zone, std::move(height).error()));
  ZonedHeight out{*height, *zone, {}};
  if (const Void* const hole = state_->voids.at(place)) {
    out.height.source = HeightSource::InVoid;
    out.in_void = text_of(*hole);
  }
  return out;
}

Expected<void> ZonedMap::heights_at(std::span<const Eigen::Vector2d> places_mm,
                                    std::span<double> heights_mm,
                                    std::span<HeightSource> sources) const {
  // A map says what is wrong with spans of other sizes.
  const bool are_spans_right = heights_mm.size() == places_mm.size() &&
                               (sources.empty() || sources.size() == places_mm.size());
  if (state_->zones.empty() || !are_spans_right) {
    PANELCAL_CHECK(state_->maps[0].heights_at(places_mm, heights_mm, sources));
  } else {
    PANELCAL_CHECK(heights_by_zone(places_mm, heights_mm, sources));
  }
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (state_->voids.at(position_mm<frame::Nominal>(places_mm[i])) != nullptr) {
      sources[i] = HeightSource::InVoid;
    }
  }
  return {};
}

/// Places in a row are mostly of one zone: its map takes them all at once.
Expected<void> ZonedMap::heights_by_zone(std::span<const Eigen::Vector2d> places_mm,
                                         std::span<double> heights_mm,
                                         std::span<HeightSource> sources) const {
  for (std::size_t begin = 0; begin < places_mm.size();) {
    const auto place = [&](std::size_t i) { return position_mm<frame::Nominal>(places_mm[i]); };
    const std::optional<std::size_t> zone = zone_at(place(begin));
    if (!zone) return failure(in_no_zone(place(begin), state_->zones.size()));
    std::size_t end = begin + 1;
    while (end < places_mm.size() && zone_at(place(end)) == zone) ++end;
    const std::size_t n = end - begin;
    const auto done =
        state_->maps[*zone].heights_at(places_mm.subspan(begin, n),
                                       heights_mm.subspan(begin, n),
                                       sources.empty() ? sources : sources.subspan(begin, n));
    if (!done) return failure(state_->of_zone(*zone, done.error()));
    begin = end;
  }
  return {};
}

std::span<const Zone> ZonedMap::zones() const {
  return state_->zones;
}

std::optional<std::size_t> ZonedMap::zone_at(const Position<frame::Nominal>& place) const {
  return first_zone(state_->zones, place);
}

const Voids& ZonedMap::voids() const {
  return state_->voids;
}

std::span<const HeightMap> ZonedMap::maps() const {
  return state_->maps;
}

std::span<const std::size_t> ZonedMap::probes(std::size_t i_zone) const {
  return state_->sorted.by_zone[i_zone];
}

std::span<const UnusedProbe> ZonedMap::unused() const {
  return state_->sorted.unused;
}

}  // namespace panelcal
