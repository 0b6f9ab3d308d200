// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"

namespace panelcal {

/// Place of a mark, seen this long after the stage reported its arrival.
struct SettleView {
  Time since_move;
  PositionEstimate<frame::Optical> seen;
};

enum class SettleMotion : std::uint8_t {
  Still,      ///< at rest as far as the views can tell
  Creeping,   ///< an exponential
  Vibrating,  ///< an oscillation that dies out
};

/// Another motion that the views do not reject: an alias of a swing that was seen too seldom.
struct SettleAlias {
  Time wait;
  double frequency_hz = 0;
};

/// Course of a stage that comes to rest.
struct SettleTime {
  SettleMotion motion = SettleMotion::Still;
  Time wait;   ///< after which the error stays below the limit; 0 where it never is above
  Time sigma;  ///< of that; of a stage that is still, half of the shortest time above 0 of a view
  Time time_constant;
  double frequency_hz = 0;  ///< of a vibration
  Length amplitude;         ///< at most, at time 0
  /// The longest wait that the views allow: four standard deviations more than the longest of
  /// `wait` and its aliases.
  Time bound;
  std::vector<SettleAlias> aliases;  ///< the likeliest first

  /// The time to wait: the bound, or two standard deviations more where that is longer.
  Time safe_wait() const { return std::max(bound, wait + 2 * sigma); }
};

/// Fits how a mark comes to rest in the views, and says after what time it is nearer to where it
/// will rest than `limit`.
///
///   seen(t) = rest + exp(-t / T) (a cos(w t) + b sin(w t)) + e
///
/// The time is that of the envelope, so that no later swing exceeds the limit. Of a covariance the
/// mean variance of both axes counts. Views that scatter more than stated make sigma larger, up to
/// where they are no decay at all.
///
/// In     views: 6 times or more after one move or several alike, any order; 2 d.o.f. or more left
/// Out    empty: `reason` says why: too few or broken views; views that scatter more than they say;
///        views that end before the mark is at rest; noise that hides a motion as large as the
///        limit
/// See    tests/calib/drift/settle_test.cc; calib/drift/decay.h
std::optional<SettleTime> fit_settle(std::span<const SettleView> views,
                                     Length limit,
                                     std::string* reason);

}  // namespace panelcal
