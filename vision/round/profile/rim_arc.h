// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace panelcal::internal {

/// The arc, as part of the rim, that tells as much of the center as some sectors do.
///
/// Sectors around [-pi a, pi a] say least of the center along their bisector. By the information
/// of a circle's fit, radius unknown, beside that of the whole rim:
///
///   r(a) = 2 a (1/2 + sin(2 pi a) / (4 pi a) - (sin(pi a) / (pi a))^2)
///
/// Of all parts of one size an arc tells the least: 70 % as one arc have 36 % of the whole rim's
/// information, and as sectors that are spread around 70 %.
///
/// In     normal: of radius and shift of a circle through the sectors, each of variance 1;
///        n_sectors: of the whole rim
/// Out    0 to 1, at least the part that the sectors are
/// See    tests/vision/round/profile/rim_arc_test.cc
double equivalent_arc(const Eigen::Matrix3d& normal, double n_sectors);

}  // namespace panelcal::internal
