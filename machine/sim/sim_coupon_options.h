// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "panelcal/calib/base/frames.h"
#include "panelcal/calib/base/units.h"

namespace panelcal {

/// How badly a virtual machine drills and stops, on top of [sim]: [sim.coupon].
struct SimCouponOptions {
  std::uint64_t seed = 1;
  Length wander;               ///< of the drill, per axis
  Length stage_repeatability;  ///< of every stop, per axis
  /// Per axis: it stops half of that too low when it moved up, too high when it moved down.
  Displacement<frame::Machine> backlash;
  int vision_tool = 1;  ///< its drill makes holes of this vision tool's kind and size
};

}  // namespace panelcal
