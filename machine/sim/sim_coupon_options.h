// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "machine/sim/sim_motion.h"

namespace panelcal {

/// What a virtual machine over a coupon is like, on top of [sim]: [sim.coupon].
struct SimCouponOptions : SimStops {
  std::uint64_t seed = 1;
  Length wander;        ///< of the drill, per axis
  int vision_tool = 1;  ///< its drill makes holes of this vision tool's kind and size
  /// Something fixed to the table, of a vision tool's look; absent: nothing is there.
  std::optional<Position<frame::Machine>> mark;
  int mark_tool = 1;
  /// How far the spindle-camera offset of a machine that was just started is from that of the warm
  /// one; after a time t the rest of it is cold exp(-t / warm_up).
  Displacement<frame::Machine> cold;
  Time warm_up = seconds(600);
};

}  // namespace panelcal
