// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "vision/round/model/band.h"
#include "vision/round/model/model.h"
#include <Eigen/Core>

#include "tests/vision/fit/edge_profile.h"

// The model of a rim for one pixel in doubles: what the loops over bands are compared with.
namespace panelcal::internal {

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

/// One pixel of a band in a piece.
inline RimPixel pixel_of(const RimBand& band, std::size_t i) {
  RimPixel p;
  p.at = {band.at_x[i], band.at_y[i]};
  p.jacobian.setIdentity();
  if (band.has_jacobian) {
    p.jacobian << band.j00[i], band.j01[i], band.j10[i], band.j11[i];
  }
  p.plane = {band.plane_x[i], band.plane_y[i]};
  p.value = band.value[i];
  p.weight = band.weight[i];
  p.x = band.x[i];
  p.y = band.y[i];
  p.clipped = band.clipped[i];
  return p;
}

inline std::vector<RimPixel> pixels_of(const RimBand& band) {
  std::vector<RimPixel> pixels;
  for (std::size_t i = 0; i < band.size(); ++i) pixels.push_back(pixel_of(band, i));
  return pixels;
}

}  // namespace panelcal::internal
