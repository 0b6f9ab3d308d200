// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>

namespace panelcal::internal {

/// The four cubic B-splines that are not zero at a place, counted in steps from the first knot;
/// beyond the ends those of the end, without slope.
struct SplineWeights {
  SplineWeights(double at, int steps) {
    const double inside = std::clamp(at, 0.0, static_cast<double>(steps));
    first = std::min(static_cast<int>(inside), steps - 1);
    const double t = inside - first;
    const double s = 1 - t;
    value = {
        s * s * s / 6, (4 + t * t * (3 * t - 6)) / 6, (4 + s * s * (3 * s - 6)) / 6, t * t * t / 6};
    if (inside != at) return;
    slope = {-s * s / 2, t * (1.5 * t - 2), -s * (1.5 * s - 2), t * t / 2};
  }

  int first = 0;
  std::array<double, 4> value;
  std::array<double, 4> slope = {0, 0, 0, 0};
};

}  // namespace panelcal::internal
