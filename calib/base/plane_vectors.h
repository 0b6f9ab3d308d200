// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace panelcal::internal {

/// The z component of the vector product; above 0 where b lies left of a.
inline double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// A direction turned by a quarter, counter-clockwise.
inline Eigen::Vector2d left_of(const Eigen::Vector2d& direction) {
  return {-direction.y(), direction.x()};
}

/// True if a map turns left into right.
inline bool is_mirror(const Eigen::Matrix2d& linear) {
  return linear(0, 0) * linear(1, 1) - linear(0, 1) * linear(1, 0) < 0;
}

}  // namespace panelcal::internal
