// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "surface/map/zoned_map.h"
#include "tools/figures/svg.h"

namespace panelcal::surface {

/// White paper over all that is_blank(), and borders of zones, for the picture of one zone's map.
///
/// Holes smaller than a pixel are dots, and of many at one pixel one.
std::string blanks(const ZonedMap& map, std::size_t i_zone, const report::View& view);

}  // namespace panelcal::surface
