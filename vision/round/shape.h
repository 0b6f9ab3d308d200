// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/round/fit.h"
#include "vision/round/window.h"

namespace panelcal::internal {

/// Where a piece of a rim lies against the fitted rim, and how sure that is.
struct RimDeviation {
  double px = 0;        ///< outwards
  double variance = 0;  ///< what noise makes of it, px^2; 0: nothing is seen there
};

/// Deviations of 48 equal sectors, by angle.
///
/// In     window: collected about the parameters without exclusions
std::vector<RimDeviation> rim_deviations(const RimWindow& window,
                                         const RimVector& parameters,
                                         const RimNoise& noise);

/// How far a rim is from round, the outer fifth of the sectors left out as debris.
struct RimRoughness {
  double rms_px = 0;        ///< beyond what noise makes
  double significance = 0;  ///< in standard deviations of chance
};

RimRoughness rim_roughness(const std::vector<RimDeviation>& deviations);

/// The strongest wave of three to eight periods around a rim: a regular polygon's sides, which a
/// rim's roughness as a whole hides where noise is strong.
struct RimLobes {
  int n = 0;
  double amplitude_px = 0;
  /// Its power over what the other waves have. White noise exceeds v with a probability of
  /// 6 (1 + v / 20.5)^-20.5, 40 once in 1e9; debris on a tenth of the rim exceeded 25 in none of
  /// 200 pictures where the amplitude was above 3 % of the radius, regular hexagons had 66 and more
  /// (tests/bench/README.md).
  double significance = 0;
};

/// Single sectors that lie far off are taken as nearer: debris has no period.
RimLobes rim_lobes(const std::vector<RimDeviation>& deviations);

}  // namespace panelcal::internal
