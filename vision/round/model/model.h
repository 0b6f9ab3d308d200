// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "vision/fit/edge_profile.h"
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

/// A pixel near a rim.
struct RimPixel {
  Eigen::Vector2f at;        ///< in the fit frame, from the window's origin
  Eigen::Matrix2f jacobian;  ///< d at / d pixel
  Eigen::Vector2f plane;     ///< in window units, from the window's middle
  float value = 0;           ///< grey level
  float weight = 1;          ///< 1 / variance of its noise
  std::int16_t x = 0;        ///< in the window
  std::int16_t y = 0;
  std::int8_t clipped = 0;  ///< 1: at full scale, -1: at zero
};

/// The picture of a disc or ring at one pixel.
struct RimValue {
  double level = 0;
  double share = 0;        ///< of the target (for a ring: its metal) in the pixel
  double distance_px = 0;  ///< inwards from the outer rim
  double inner_px = 0;     ///< inwards from the inner rim
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

using RimGradient = std::array<double, kRimParameters>;

/// The picture of a disc or ring as a function of its parameters.
///
///   I = light (level + contrast (E(R) - E(R_inner)) + hole E(R_inner)) + slopes (E(R) -
///   E(R_inner))
///
/// with light = 1 + a linear function, E the edge profile and lengths measured in the fit frame,
/// then brought to pixels by the frame's local scale across the rim.
inline RimValue rim_value(const RimPixel& pixel,
                          const RimVector& p,
                          bool is_ring,
                          RimGradient* gradient) {
  constexpr double kTinyRadius = 1e-6;
  const double u = pixel.plane.x();
  const double v = pixel.plane.y();
  const double light = 1 + u * p[kLightX] + v * p[kLightY];
  const double contrast = light * p[kContrast] + u * p[kContrastX] + v * p[kContrastY];
  const double j00 = pixel.jacobian(0, 0);
  const double j01 = pixel.jacobian(0, 1);
  const double j10 = pixel.jacobian(1, 0);
  const double j11 = pixel.jacobian(1, 1);

  /// One rim: its profile, the unit normal in the frame and units per px across it.
  struct Rim {
    EdgeValue edge;
    double nx, ny, per_unit, distance_px;
  };
  const auto rim_of = [&](double dx, double dy, double radius) {
    const double r = std::max(std::sqrt(dx * dx + dy * dy), kTinyRadius);
    Rim rim;
    rim.nx = dx / r;
    rim.ny = dy / r;
    const double oval =
        1 + p[kOval] * (rim.nx * rim.nx - rim.ny * rim.ny) + p[kOvalDiagonal] * 2 * rim.nx * rim.ny;
    const double mx = j00 * rim.nx + j10 * rim.ny;
    const double my = j01 * rim.nx + j11 * rim.ny;
    rim.per_unit = 1 / std::max(std::sqrt(mx * mx + my * my), kTinyRadius);
    rim.distance_px = (radius * oval - r) * rim.per_unit;
    rim.edge = edge_profile(
        rim.distance_px, p[kSigma], radius * rim.per_unit, mx * rim.per_unit, my * rim.per_unit);
    return rim;
  };

  const double dx = pixel.at.x() - p[kCenterX];
  const double dy = pixel.at.y() - p[kCenterY];
  const Rim outer = rim_of(dx, dy, p[kRadius]);
  RimValue value;
  value.distance_px = outer.distance_px;
  value.share = outer.edge.share;
  value.level = light * p[kLevel] + contrast * outer.edge.share;
  const double d_outer = contrast * outer.edge.d_distance * outer.per_unit;
  if (gradient) {
    RimGradient& g = *gradient;
    g[kCenterX] = d_outer * outer.nx;
    g[kCenterY] = d_outer * outer.ny;
    g[kRadius] = d_outer + contrast * outer.edge.d_radius * outer.per_unit;
    g[kSigma] = contrast * outer.edge.d_sigma;
    g[kOval] = d_outer * p[kRadius] * (outer.nx * outer.nx - outer.ny * outer.ny);
    g[kOvalDiagonal] = d_outer * p[kRadius] * 2 * outer.nx * outer.ny;
  }
  if (is_ring) {
    const Rim inner = rim_of(dx - p[kHoleX], dy - p[kHoleY], p[kInnerRadius]);
    const double gain = light * p[kHole] - contrast;
    value.inner_px = inner.distance_px;
    value.share -= inner.edge.share;
    value.level += gain * inner.edge.share;
    if (gradient) {
      RimGradient& g = *gradient;
      const double d_inner = gain * inner.edge.d_distance * inner.per_unit;
      g[kHoleX] = d_inner * inner.nx;
      g[kHoleY] = d_inner * inner.ny;
      g[kCenterX] += g[kHoleX];
      g[kCenterY] += g[kHoleY];
      g[kInnerRadius] = d_inner + gain * inner.edge.d_radius * inner.per_unit;
      g[kHole] = light * inner.edge.share;
      g[kSigma] += gain * inner.edge.d_sigma;
      g[kOval] += d_inner * p[kInnerRadius] * (inner.nx * inner.nx - inner.ny * inner.ny);
      g[kOvalDiagonal] += d_inner * p[kInnerRadius] * 2 * inner.nx * inner.ny;
    }
  }
  if (gradient) {
    RimGradient& g = *gradient;
    const double lit =
        (value.level - value.share * (u * p[kContrastX] + v * p[kContrastY])) / light;
    g[kLevel] = light;
    g[kLightX] = lit * u;
    g[kLightY] = lit * v;
    g[kContrast] = light * value.share;
    g[kContrastX] = value.share * u;
    g[kContrastY] = value.share * v;
  }
  return value;
}

}  // namespace panelcal::internal
