// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "surface/map/file.h"

namespace panelcal::surface {

/// Corners of the probes' hull, counter-clockwise, mm.
std::vector<Eigen::Vector2d> hull_of(const HeightMap& map);

}  // namespace panelcal::surface
