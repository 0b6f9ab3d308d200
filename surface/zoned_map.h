// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "panelcal/calib/base/expected.h"
#include "panelcal/surface/area.h"
#include "panelcal/surface/height_map.h"
#include "panelcal/surface/probe_point.h"
#include "panelcal/surface/voids.h"

namespace panelcal {

/// A part of the table with a surface of its own: one panel of several, a step, a coupon.
struct Zone {
  Area area;
  std::string name;
  HeightMapOptions options = {};
  Place from;  ///< where it was read, for messages
};

/// Why a probe takes no part in any zone's surface. Wild ones are HeightMap::outliers().
struct UnusedProbe {
  std::size_t i_point = 0;
  std::string text;  ///< `column 3 row 4 lies in "hole of tool 3"`, `... lies in no zone`
};

/// A height, and whose it is.
struct ZonedHeight {
  HeightAt height;  ///< source is InVoid where the surface is not there
  std::size_t i_zone = 0;
  std::string void_name;  ///< of the void that the place lies in; else empty
};

/// Height maps of several zones, and voids in which no probe is believed.
///
/// Each zone has the surface of its own probes. Where zones overlap, the one declared first holds,
/// for places and for probes: so a coupon can be declared before the panel that it is cut from.
/// Without any zone there is one, all over the table. A value: copies share what was made.
///
/// See    tests/surface/zoned_map_test.cc
class ZonedMap {
 public:
  /// Fails  config-value: as check_area(), two zones of one name; grid-invalid: a zone without
  ///        probes; as HeightMap::of_probes(), the zone named
  static Expected<ZonedMap> of_probes(std::span<const ProbePoint> points,
                                      std::vector<Zone> zones,
                                      Voids voids,
                                      const HeightMapOptions& without_zones = {});

  /// Fails  grid-invalid: outside of all zones; as HeightMap::height_at(), the zone named
  Expected<ZonedHeight> height_at(const Position<frame::Nominal>& place) const;

  std::span<const Zone> zones() const;
  const HeightMap& map(std::size_t i_zone) const;
  /// In the order of the probes.
  std::span<const UnusedProbe> unused() const;

 private:
  struct State;
  explicit ZonedMap(std::shared_ptr<const State> state) : state_(std::move(state)) {}

  std::shared_ptr<const State> state_;
};

}  // namespace panelcal
