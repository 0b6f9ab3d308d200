// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/expected.h"
#include "surface/map/height_lattice.h"
#include "surface/map/zoned_map.h"

namespace panelcal::surface {

/// Evenly spaced columns and rows over the rectangle of a map's probes, its edges included.
struct GridAxes {
  LatticeAxis x, y;
};

/// Of `--grid NXxNY`.
///
/// Fails  usage, of `command`: no such text
Expected<GridAxes> grid_axes(const std::string& command,
                             const std::string& text,
                             const ZonedMap& map);

}  // namespace panelcal::surface
