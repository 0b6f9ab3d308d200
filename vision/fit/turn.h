// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace panelcal::internal {

/// Of an odd polynomial of least error for the arc tangent of 0 .. 1, over a whole turn.
inline constexpr std::array<double, 4> kTurnTerms = {0.158976, -0.051060, 0.023487, -0.006349};

/// The direction of (x, y), counted from x towards y, in turns from 0 to 1; to within 0.0002 and
/// several times faster than atan2.
///
/// See    tests/vision/fit/turn_test.cc
inline double turn_of(double x, double y) {
  const double ax = std::abs(x);
  const double ay = std::abs(y);
  const double larger = std::max(ax, ay);
  if (!(larger > 0)) return 0;
  const double t = std::min(ax, ay) / larger;
  const double t2 = t * t;
  double turn =
      t * (kTurnTerms[0] + t2 * (kTurnTerms[1] + t2 * (kTurnTerms[2] + t2 * kTurnTerms[3])));
  if (ay > ax) turn = 0.25 - turn;
  if (x < 0) turn = 0.5 - turn;
  return y < 0 ? 1 - turn : turn;
}

}  // namespace panelcal::internal
