// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

#include "calib/base/units.h"

namespace panelcal::internal {

enum class FreshFrame : std::uint8_t { Grabbed, Lost, Endless };

/// Grabs frames until the last one was exposed after the call began.
///
/// Drivers and networks keep frames waiting. Such a frame comes at once; a new one takes about a
/// frame period. So frames are passed over until two in a row had to be waited for; the first of
/// them, and in cameras that expose while they send also the second, may have been begun before the
/// call, so the third is taken.
///
/// In     period: between two frames of the camera
///        grab: takes the next frame, false if there is none; now: a clock that never goes back
/// Out    Endless: frames keep coming faster than the camera makes them
FreshFrame grab_fresh_frame(Time period,
                            const std::function<bool()>& grab,
                            const std::function<Time()>& now);

}  // namespace panelcal::internal
