// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/fit/edge_profile.h"
#include "vision/fit/gauss_table.h"

namespace panelcal::internal {

/// Share of a pixel inside a large disc, and its derivatives.
struct EdgeValue {
  double share = 0;
  double d_distance = 0;  ///< per px of distance
  double d_sigma = 0;     ///< per px of sigma
  double d_radius = 0;    ///< per px of radius, at fixed distance
};

/// The profile of a disc's edge behind a Gaussian lens and square pixels.
///
///   share = Phi(t) - q He3(t) phi(t),   t = (distance - sigma^2 / 2 radius) / sigma
///
/// sigma^2 is the lens's variance plus 1/12 of the pixel square, the same in all directions. What
/// depends on the direction n of the edge is the fourth cumulant of the square,
/// -(nx^4 + ny^4) / 120, hence q = cumulant / (24 sigma^4) (Edgeworth). A convex rim blurs inwards
/// by sigma^2 / (2 radius), as heat does. Errors are below 1e-4 for radius >= 8, lens >= 0.5 px.
///
/// In     distance_px: inwards from the rim; n: unit normal in the picture
/// See    tests/vision/fit/edge_profile_test.cc
inline EdgeValue edge_profile(
    double distance_px, double sigma_px, double radius_px, double nx, double ny) {
  const double t = distance_px / sigma_px - 0.5 * sigma_px / radius_px;
  if (t > kEdgeReach) return {1, 0, 0, 0};
  if (t < -kEdgeReach) return {0, 0, 0, 0};
  const double sigma2 = sigma_px * sigma_px;
  const double q = -(nx * nx * nx * nx + ny * ny * ny * ny) / (120 * 24 * sigma2 * sigma2);
  const auto [cdf, phi] = gauss(t);
  const double t2 = t * t;
  const double he3 = t * (t2 - 3);
  const double he4 = t2 * (t2 - 6) + 3;
  const double d_t = phi * (1 + q * he4);
  EdgeValue edge;
  edge.share = cdf - q * he3 * phi;
  edge.d_distance = d_t / sigma_px;
  edge.d_sigma = d_t * (-distance_px / sigma2 - 0.5 / radius_px) + 4 * q / sigma_px * he3 * phi;
  edge.d_radius = d_t * 0.5 * sigma_px / (radius_px * radius_px);
  return edge;
}

}  // namespace panelcal::internal
