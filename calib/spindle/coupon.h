// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/base/machine_uncertainty.h"

namespace panelcal {

/// Direction from which the stage came to rest: per axis +1 moving up, -1 moving down, 0 if that is
/// not known or makes no difference.
struct Approach {
  int x = 0;
  int y = 0;
  friend bool operator==(const Approach&, const Approach&) = default;
};

/// One look at a hole. Several pictures without a move in between are one look.
struct CouponView {
  Position<frame::Machine> spindle;       ///< place of the stage, not of its optical axis
  Approach approach;                      ///< direction from which it came
  PositionEstimate<frame::Optical> seen;  ///< of the hole's middle
  /// d seen / d camera parameters, whose error all looks share; see SpindleCameraFit::by_camera.
  CameraJacobian by_camera = CameraJacobian::Zero();
};

/// A hole of the coupon and all looks at it.
struct CouponHole {
  Position<frame::Machine> drilled;  ///< place to which the spindle was sent
  Approach approach;                 ///< direction from which it came
  std::vector<CouponView> views;     ///< one or more
};

}  // namespace panelcal
