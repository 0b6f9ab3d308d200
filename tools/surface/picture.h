// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tools/figures/contour_map.h"
#include "tools/surface/text.h"

namespace panelcal::surface {

/// Corners of the probes' hull, counter-clockwise, mm.
std::vector<Eigen::Vector2d> hull_of(const HeightMap& map);

/// The extrapolated and the filled area, hatched. `id` as that of the map it is drawn on.
std::string hatching(const StoredMap& stored, const report::View& view, const std::string& id);

/// A dot for each probe that makes the surface.
std::string probe_dots(const StoredMap& stored,
                       const report::View& view,
                       std::string_view css_class);

/// Of one zone, heights with contours, and sigmas; probes, those left out (red), and those that are
/// missing or not used. Voids and other zones are blank.
std::vector<report::Drawing> zone_drawings(const MadeMap& made, std::size_t i_zone);

}  // namespace panelcal::surface
