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

/// As grab_fresh_frame, of a camera whose driver gives each frame a time stamp on the clock of
/// `now`: frames that began before the call, `longest` before their stamp at most, are passed over.
/// A stamp that is no time of that clock (0, in the future, or more than 10 s ago) is not believed,
/// and the frames are waited for instead.
///
/// In     longest: from the begin of the first row's exposure to the stamp
///        stamp: of the frame that was grabbed last
FreshFrame grab_stamped_frame(Time period,
                              Time longest,
                              const std::function<bool()>& grab,
                              const std::function<Time()>& stamp,
                              const std::function<Time()>& now);

}  // namespace panelcal::internal
