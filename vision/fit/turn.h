// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace panelcal::internal {

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
  // Odd polynomial of least error on 0 .. 1, over a whole turn.
  double turn = t * (0.158976 + t2 * (-0.051060 + t2 * (0.023487 + t2 * -0.006349)));
  if (ay > ax) turn = 0.25 - turn;
  if (x < 0) turn = 0.5 - turn;
  return y < 0 ? 1 - turn : turn;
}

}  // namespace panelcal::internal
