// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "calib/base/plane_vectors.h"
#include "program/geometry/arcs.h"
#include <Eigen/Core>

namespace panelcal {

/// A line or an arc of at most half a turn, by the share of it that is done.
class ArcPath {
 public:
  explicit ArcPath(const Arc& arc) : arc_(arc) {
    if (arc.straight) return;
    const Eigen::Vector2d start = arc.start_mm - arc.center_mm;
    const Eigen::Vector2d end = arc.end_mm - arc.center_mm;
    turn_rad_ = std::atan2(internal::cross(start, end), start.dot(end));
    // Half a turn may come out on either side.
    if ((turn_rad_ > 0) == arc.clockwise) turn_rad_ = -turn_rad_;
  }

  Eigen::Vector2d at(double share) const {
    if (share <= 0) return arc_.start_mm;
    if (share >= 1) return arc_.end_mm;
    if (arc_.straight) return arc_.start_mm + share * (arc_.end_mm - arc_.start_mm);
    const double c = std::cos(share * turn_rad_);
    const double s = std::sin(share * turn_rad_);
    const Eigen::Vector2d from_center = arc_.start_mm - arc_.center_mm;
    return arc_.center_mm + Eigen::Vector2d(c * from_center.x() - s * from_center.y(),
                                            s * from_center.x() + c * from_center.y());
  }

  /// The part between two shares.
  Arc part(double begin, double end) const {
    const Eigen::Vector2d start_mm = at(begin), end_mm = at(end);
    const Eigen::Vector2d center_mm =
        arc_.straight ? Eigen::Vector2d(0.5 * (start_mm + end_mm)) : arc_.center_mm;
    return {start_mm, end_mm, center_mm, arc_.clockwise, arc_.straight};
  }

  double length_mm() const {
    return arc_.straight ? (arc_.end_mm - arc_.start_mm).norm()
                         : std::abs(turn_rad_) * (arc_.start_mm - arc_.center_mm).norm();
  }

 private:
  Arc arc_;
  double turn_rad_ = 0;
};

}  // namespace panelcal
