// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace panelcal::internal {

/// Move of a circle through a rim by the rim's own shape.
struct RimWaves {
  /// Expected power of the wave of one period, beyond the floor: it looks like a shift.
  double own = 0;
  /// Expected power of it in all, and what of its uncertainty must be added for intervals to hold.
  double first = 0;
};

/// Carries the power of the waves of 2, 3, 4 ... periods around a rim on to that of one period.
///
///   S(k) = floor + own ((1 + c^2) / (k^2 + c^2))^2   or   floor + own exp((1 - k^2) / 2 c^2)
///
/// c, the rim's radius over its correlation length, and own are unknown: the mean over what the
/// powers leave open, each of which is its expectation times a chi square of 2 over 2. A rim is
/// round until shown otherwise; a displaced arc, whose first waves go together, is steep (c small),
/// so that its shift is within what is expected.
///
/// In     powers: of 2, 3, 4 ... periods, per sector as in wave_powers(); floor: what noise makes;
///        rough_chance: that the rim has a shape of its own that matters, before anything is seen
/// Source Whittle 1953 (likelihood of a spectrum)
/// See    tests/vision/round/profile/rim_waves_test.cc
RimWaves extrapolate_waves(std::span<const double> powers, double floor, double rough_chance);

}  // namespace panelcal::internal
