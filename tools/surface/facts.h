// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "surface/map/file.h"

namespace panelcal::surface {

/// A part of the probes' hull for which no probe vouches.
struct FilledArea {
  Position<frame::Nominal> middle;  ///< of its places
  double area_mm2 = 0;
};

/// A height or a sigma, and where.
struct Extreme {
  Length value;
  Position<frame::Nominal> at;
};

/// The figures of a map for an operator, within the probes' hull.
struct MapFacts {
  Extreme lowest, highest, worst_sigma;
  Length usual_sigma;              ///< the median over the hull
  Length residual_rms;             ///< of the probes that make the surface, about it
  Length stated_rms;               ///< stated scatter of these probes
  double hull_mm2 = 0;             ///< area of the surface
  std::vector<FilledArea> filled;  ///< the largest first; looked for in steps of the hull by 100

  double filled_share() const;
};

/// In     is_surface: whether a place has a surface of this map: no other zone, no void; empty: all
MapFacts facts_of(const StoredMap& stored,
                  const std::function<bool(const Position<frame::Nominal>&)>& is_surface = {});

}  // namespace panelcal::surface
