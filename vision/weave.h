// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace panelcal::internal {

/// The look of plain-woven glass in resin, about -1 to 1, at a place on the panel.
///
/// Warp and weft make a checkerboard of bright and dark knots; yarns wander a little, are unequally
/// thick, and resin and filaments add an irregular mottle.
double weave_level(const Eigen::Vector2d& at_mm, double period_mm, std::uint64_t seed);

}  // namespace panelcal::internal
