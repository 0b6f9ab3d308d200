// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "calib/base/plane_vectors.h"
#include "program/model/operation.h"
#include <Eigen/Core>

namespace panelcal {

/// A corrected arc of at most half a circle, mm.
struct ArcShape {
  Eigen::Vector2d center;
  Eigen::Vector2d from;  ///< from the center to the end where counter-clockwise begins
  Eigen::Vector2d to;

  ArcShape(const Eigen::Vector2d& start_mm, const Rout& rout)
      : center(rout.corrected_center.in_mm()) {
    from = start_mm - center;
    to = rout.corrected.in_mm() - center;
    if (rout.kind == RoutKind::Clockwise) from.swap(to);
  }

  double radius_mm() const { return (from.norm() + to.norm()) / 2; }
  double length_mm() const {
    return radius_mm() * std::atan2(std::abs(internal::cross(from, to)), from.dot(to));
  }
  /// The arc has a point in this direction from its center.
  bool covers(const Eigen::Vector2d& direction) const {
    // Both signs also fit the opposite of an arc without length.
    const double nearer = std::max(direction.dot(from), direction.dot(to));
    return internal::cross(from, direction) >= 0 && internal::cross(direction, to) >= 0 &&
           nearer >= -1e-6 * radius_mm();
  }
  /// Calls `see` with every point that is the farthest right, up, left or down between the ends.
  template <class See>
  void for_each_bulge(See see) const {
    for (const Eigen::Vector2d& direction : {Eigen::Vector2d(1, 0),
                                             Eigen::Vector2d(0, 1),
                                             Eigen::Vector2d(-1, 0),
                                             Eigen::Vector2d(0, -1)}) {
      if (covers(direction)) see(Eigen::Vector2d(center + radius_mm() * direction));
    }
  }
};

}  // namespace panelcal
