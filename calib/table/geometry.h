// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include <Eigen/Core>

namespace panelcal {

/// The figures of a table for its builder, from the map; means over its rectangle.
///
///   x error = scale_x x + ...          y error = scale_y y + ...          (1)
///   squareness: the angle between the axes is 90 degrees minus this       (rad)
///
/// Straightness and linearity are Legendre's polynomials of degree 2 and 3 along the axis, each by
/// its value at the axis' high end.
struct TableGeometry {
  enum Index {
    ScaleX,
    ScaleY,
    Squareness,
    LinearityX2,  ///< x error along x, mm
    LinearityX3,
    LinearityY2,  ///< y error along y
    LinearityY3,
    StraightnessX2,  ///< y error along x
    StraightnessX3,
    StraightnessY2,  ///< x error along y
    StraightnessY3,
  };
  static constexpr int kSize = 11;
  Eigen::Matrix<double, kSize, 1> value = Eigen::Matrix<double, kSize, 1>::Zero();
  Eigen::Matrix<double, kSize, kSize> cov = Eigen::Matrix<double, kSize, kSize>::Zero();
  static std::string_view name(Index index);
};

}  // namespace panelcal
