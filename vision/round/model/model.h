// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <Eigen/Core>

namespace panelcal::internal {

/// Parameter order; units are the fit frame's (about px) and grey levels.
enum RimParameter {
  kCenterX,
  kCenterY,
  kRadius,
  kSigma,   ///< of the edge, pixel width included; px
  kLevel,   ///< background in the window's middle
  kLightX,  ///< relative slope of the light per window unit: it multiplies all levels
  kLightY,
  kContrast,     ///< target minus background
  kInnerRadius,  ///< rings only, as are the next three
  kHole,         ///< level in the hole minus background: the hole may show another material
  kHoleX,        ///< middle of the hole minus middle of the rim
  kHoleY,
  kOval,  ///< radius (1 + oval cos 2 phi + oval_diagonal sin 2 phi): tilt, to first order
  kOvalDiagonal,
  kContrastX,  ///< the target's own slope beyond the light's
  kContrastY,
  kRimParameters
};

using RimVector = Eigen::Matrix<double, kRimParameters, 1>;

/// Parameters that a fit is free to choose.
struct RimFreedom {
  bool is_ring = false;
  bool is_oval = false;
  bool has_own_slope = false;

  /// The free parameters' indices, in order; returns how many.
  int columns(std::array<int, kRimParameters>& indices) const {
    int n = 0;
    for (int i = 0; i < kInnerRadius; ++i) indices[static_cast<std::size_t>(n++)] = i;
    for (int i = kInnerRadius; is_ring && i < kOval; ++i)
      indices[static_cast<std::size_t>(n++)] = i;
    for (int i = kOval; is_oval && i < kContrastX; ++i) indices[static_cast<std::size_t>(n++)] = i;
    for (int i = kContrastX; has_own_slope && i < kRimParameters; ++i) {
      indices[static_cast<std::size_t>(n++)] = i;
    }
    return n;
  }
};

/// Parts of a window where the picture is flat but for the light's gradient.
enum class RimZone : std::uint8_t { Outside, Target, Hole };
inline constexpr std::size_t kRimZones = 3;

/// A flat zone's level as (constant, x slope, y slope) in window units.
inline Eigen::Vector3d zone_level(const RimVector& p, RimZone zone) {
  double level = p[kLevel];
  if (zone == RimZone::Target) level += p[kContrast];
  if (zone == RimZone::Hole) level += p[kHole];
  Eigen::Vector3d plane(level, level * p[kLightX], level * p[kLightY]);
  if (zone == RimZone::Target) plane.tail<2>() += Eigen::Vector2d(p[kContrastX], p[kContrastY]);
  return plane;
}

/// Its derivative: rows as above, a column for each parameter.
inline Eigen::Matrix<double, 3, kRimParameters> zone_level_jacobian(const RimVector& p,
                                                                    RimZone zone) {
  Eigen::Matrix<double, 3, kRimParameters> d;
  d.setZero();
  const Eigen::Vector3d light(1, p[kLightX], p[kLightY]);
  d.col(kLevel) = light;
  if (zone == RimZone::Target) d.col(kContrast) = light;
  if (zone == RimZone::Hole) d.col(kHole) = light;
  double level = p[kLevel];
  if (zone == RimZone::Target) level += p[kContrast];
  if (zone == RimZone::Hole) level += p[kHole];
  d(1, kLightX) = level;
  d(2, kLightY) = level;
  if (zone == RimZone::Target) {
    d(1, kContrastX) = 1;
    d(2, kContrastY) = 1;
  }
  return d;
}

}  // namespace panelcal::internal
