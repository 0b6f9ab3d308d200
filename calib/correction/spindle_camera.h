// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include <Eigen/Core>

namespace panelcal {

/// The spindle-camera offset d, the only place that knows its sign:
///
///   d = (point seen on the optical axis) - (point under the spindle),   machine frame
struct SpindleCameraOffset {
  Displacement<frame::Machine> offset;
  Eigen::Matrix2d cov_mm2 = Eigen::Matrix2d::Zero();

  /// The command to the spindle axis with which the camera looks at p.
  Position<frame::Machine> spindle_to_see(const Position<frame::Machine>& p) const {
    return p - offset;
  }
  /// Place at which the camera looks while the spindle axis is at s.
  Position<frame::Machine> optical_axis(const Position<frame::Machine>& s) const {
    return s + offset;
  }
};

/// Machine position of a point at `seen` from the optical axis.
inline Position<frame::Machine> machine_from_optical(const Position<frame::Machine>& optical_axis,
                                                     const Position<frame::Optical>& seen) {
  return optical_axis + displacement_mm<frame::Machine>(seen.in_mm());
}

}  // namespace panelcal
