// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "surface/fit/area.h"
#include "surface/fit/probe_point.h"
#include "surface/map/height_map.h"
#include "surface/map/voids.h"

namespace panelcal {

/// Each is a surface of its own, which takes its time.
inline constexpr std::size_t kMostZones = 64;

/// A part of the table with a surface of its own: one panel of several, a step, a coupon.
struct Zone {
  Area area;
  std::string name;
  HeightMapOptions options = {};
  Place from;  ///< place of the reading in a file, for messages
};

/// The reason why a probe is in no zone's surface. Wild ones are HeightMap::outliers().
struct UnusedProbe {
  std::size_t i_point = 0;
  std::string reason;  ///< `it lies in no zone`, `it may touch "hole of tool 3" (panel.exc:40)`
};

/// Probes sorted by the zone whose surface they make.
struct SortedProbes {
  std::vector<std::vector<std::size_t>> by_zone;  ///< indices, rising; one list without zones
  std::vector<UnusedProbe> unused;                ///< in the order of the probes
};

/// Fails  config-value: as check_area(), two zones of one name, more than kMostZones
Expected<SortedProbes> sort_probes(std::span<const ProbePoint> points,
                                   std::span<const Zone> zones,
                                   const Voids& voids);

/// A height, and whose it is.
struct ZonedHeight {
  HeightAt height;  ///< source is InVoid where the surface is not there
  std::size_t i_zone = 0;
  std::string in_void;  ///< text_of() the void that the place lies in; else empty
};

/// Step from one zone's surface up to its neighbour's.
struct ZoneStep {
  Length height;
  std::size_t i_from = 0, i_to = 0;  ///< zones

  /// True if a way across can be cut so that the tool keeps to a height tolerance: way_cuts() takes
  /// no larger step for a bend, however fine its samples.
  bool is_followed_within(Length tolerance) const {
    constexpr double kShare = 0.05;
    return std::abs(height.in_mm()) <= kShare * tolerance.in_mm();
  }
};

/// Height maps of several zones, and voids in which no probe is believed.
///
/// Each zone has the surface of its own probes. Where zones overlap, the one declared first holds,
/// for places and for probes: so a coupon can be declared before the panel that it is cut from.
/// Without any zone there is one, all over the table. A value: copies share what was made.
///
/// See    tests/surface/map/zoned_map_test.cc
class ZonedMap {
 public:
  /// One map all over the table, without voids.
  ZonedMap(HeightMap map);

  /// Fails  config-value: as check_area(), two zones of one name; grid-invalid: a zone without
  ///        probes; as HeightMap::of_probes(), the zone named
  static Expected<ZonedMap> of_probes(std::span<const ProbePoint> points,
                                      std::vector<Zone> zones,
                                      Voids voids,
                                      const HeightMapOptions& without_zones = {});

  /// The same of maps that were made before, one for each zone, or one if there are none.
  ///
  /// Precondition: sorted is of these zones, and each map of its probes
  static ZonedMap of_maps(std::vector<Zone> zones,
                          Voids voids,
                          SortedProbes sorted,
                          std::vector<HeightMap> maps);

  /// Fails  grid-invalid: outside of all zones; as HeightMap::height_at(), the zone named
  Expected<ZonedHeight> height_at(const Position<frame::Nominal>& place) const;

  /// As HeightMap::heights_at(), each place by its own zone; sources know voids.
  Expected<void> heights_at(std::span<const Eigen::Vector2d> places_mm,
                            std::span<double> heights_mm,
                            std::span<HeightSource> sources = {}) const;

  /// Declared ones; none is one map all over the table.
  std::span<const Zone> zones() const;
  /// The first one that holds a place, 0 without zones; empty if none does.
  std::optional<std::size_t> zone_at(const Position<frame::Nominal>& place) const;
  const Voids& voids() const;
  /// One for each zone, or one without.
  std::span<const HeightMap> maps() const;
  const HeightMap& map(std::size_t i_zone) const { return maps()[i_zone]; }
  /// Of all lattices: what a way is looked at in, so that no bend is overlooked.
  Length finest_cell() const;
  /// Between two places close to each other that lie in different zones; empty of one zone, and
  /// where a map does not reach.
  std::optional<ZoneStep> step_between(const Position<frame::Nominal>& from,
                                       const Position<frame::Nominal>& to) const;
  /// Indices of a zone's probes, rising: what HeightMap::kept() and outliers() count in.
  std::span<const std::size_t> probes(std::size_t i_zone) const;
  /// In the order of the probes.
  std::span<const UnusedProbe> unused() const;

 private:
  struct State;
  explicit ZonedMap(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  Expected<void> heights_by_zone(std::span<const Eigen::Vector2d> places_mm,
                                 std::span<double> heights_mm,
                                 std::span<HeightSource> sources) const;

  std::shared_ptr<const State> state_;
};

}  // namespace panelcal
