// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace panelcal::internal {

/// Covariance of a shift that the blur of an edge, as it changes around the rim, may hide, px^2.
///
/// Sharper on one side than on the other: a lamp from the side on the slope of the edge makes it
/// so, and coma. A bright or dark band x inside of an edge of sigma s moves it by s / 2x of what it
/// seems to blur it; bands that matter are at least half an s inside. More blurred along one
/// direction, on both sides: colours that a lens shifts against each other, whose mean is off by a
/// part of their spread; astigmatism and vibration look the same, but only as much counts as a lens
/// makes. Both count beyond chance only, and colours if chance would hardly make them.
///
/// In     blurs: by sector, px of the edge's sigma more than the rim's; use: sectors that count;
///        sigma_px: of the rim's edge
/// See    tests/vision/round/profile/rim_blur_test.cc; docs/formulation.md, Locating
Eigen::Matrix2d hidden_by_blur(const Eigen::VectorXd& blurs,
                               const std::vector<char>& use,
                               double sigma_px);

}  // namespace panelcal::internal
