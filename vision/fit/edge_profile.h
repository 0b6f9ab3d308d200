// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panelcal::internal {

/// The profile of a disc's edge is that behind a Gaussian lens and square pixels.
///
///   share = Phi(t) - q He3(t) phi(t),   t = (distance - sigma^2 / 2 radius) / sigma
///
/// sigma^2 is the lens's variance plus 1/12 of the pixel square, the same in all directions. What
/// depends on the direction n of the edge is the fourth cumulant of the square,
/// -(nx^4 + ny^4) / 120, hence q = cumulant / (24 sigma^4) (Edgeworth). A convex rim blurs inwards
/// by sigma^2 / (2 radius), as heat does. Errors are below 1e-4 for radius >= 8, lens >= 0.5 px.
///
/// The distance counts inwards from the rim. vision/round/model/band.cc computes it for rims,
/// vision/polygon/model.cc for straight edges; tests/vision/fit/edge_profile_test.cc holds it
/// against exact integrals.
///
/// Variance of a unit square along any direction: what a pixel's width adds to the lens blur.
inline constexpr double kPixelVariance = 1.0 / 12.0;

}  // namespace panelcal::internal
