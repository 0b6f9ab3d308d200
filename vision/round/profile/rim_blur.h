// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace panelcal::internal {

/// Covariance of a shift that the blur of an edge, as it changes around the rim, may hide, px^2.
///
/// Sharper on one side than on the other: a lamp from the side on the slope of the edge makes it
/// so, and coma. A bright or dark band x inside of an edge of sigma s moves it by s / 2x of what it
/// seems to blur it; bands that matter are at least half an s inside. It counts beyond chance.
/// More blurred along one direction, on both sides: colours that a lens shifts against each other.
/// Of three of unknown strength, the middle one in its place, the mean square of their mean is a
/// third of the mean variance of their spread. It counts beyond chance and a sound lens's
/// astigmatism, and as far as a lens makes it: vibration looks the same.
///
/// In     blurs: by sector, px of the edge's sigma more than the rim's; use: sectors that count;
///        sigma_px: of the rim's edge
/// Source the moments of three strengths that are even in their simplex (Dirichlet); Seidel's terms
/// See    tests/vision/round/profile/rim_blur_test.cc; docs/formulation.md, Locating
Eigen::Matrix2d hidden_by_blur(const Eigen::VectorXd& blurs,
                               const std::vector<char>& use,
                               double sigma_px);

}  // namespace panelcal::internal
