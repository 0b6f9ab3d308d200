// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "surface/map/height_map.h"
#include <Eigen/Core>

namespace panelcal {

/// A rectangle of the table over which figures of its surface are stated.
struct SurfaceArea {
  Eigen::Vector2d center_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d half_mm = Eigen::Vector2d::Zero();  ///< half of its sides, above 0

  friend bool operator==(const SurfaceArea&, const SurfaceArea&) = default;
};

/// A surface in six heights, with their covariance.
///
///   z = offset + tilt_x u + tilt_y v + bow_x u^2 + bow_y v^2 + twist u v
///
/// u and v go from -1 to 1 over the area. So offset is the height of its middle above Z0, and tilt,
/// bow and twist are heights of its edges (corners) above that: as far as they change, holes change
/// their depth.
struct SurfaceFigures {
  static constexpr int kSize = 6;
  /// "offset", "tilt_x", "tilt_y", "bow_x", "bow_y", "twist", as the ledger has them.
  static constexpr std::array<std::string_view, kSize> kNames = {
      "offset", "tilt_x", "tilt_y", "bow_x", "bow_y", "twist"};

  SurfaceArea area;
  Eigen::Matrix<double, kSize, 1> value_mm = Eigen::Matrix<double, kSize, 1>::Zero();
  Eigen::Matrix<double, kSize, kSize> cov_mm2 = Eigen::Matrix<double, kSize, kSize>::Zero();
};

/// The figures of a map, by least squares over places all over the area; what the map is unsure of
/// is in their covariance.
///
/// Fails  grid-invalid: the map does not reach over all of the area; a map of a grid model, which
///        has no covariance of its errors
/// See    tests/machine/calibrate/surface/change_test.cc
Expected<SurfaceFigures> figures_of(const HeightMap& map, const SurfaceArea& area);

/// The largest standard deviation of a height within the area. Precondition: figures_of() it.
Length largest_sigma(const HeightMap& map, const SurfaceArea& area);

/// The rectangle of the probes that make a map.
SurfaceArea area_of(const HeightMap& map);

/// In lines, a figure each: `tilt x      +12.3 um +- 1.1 at the edge (82.0 um/m)`.
std::string report(const SurfaceFigures& figures);

}  // namespace panelcal
