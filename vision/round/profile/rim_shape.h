// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace panelcal::internal {

/// A rim's own shape by sector, px outwards: what its deviations from a circle show beyond noise.
///
/// Waves of two periods and more, each shrunk by the part of its power that noise makes. A band
/// along a rim that is unrolled along this shape shows the edge itself, not an edge that is blurred
/// by the rim's deviations, and a linear measure of it is in its linear range.
///
/// In     residuals: about the circle, px; use: sectors that lie on it, the others count as 0;
///        variance: of a sector by noise, px^2
/// Source Wiener 1949
/// See    tests/vision/round/profile/rim_shape_test.cc
Eigen::VectorXd rim_shape(const Eigen::VectorXd& residuals,
                          const std::vector<char>& use,
                          double variance);

}  // namespace panelcal::internal
