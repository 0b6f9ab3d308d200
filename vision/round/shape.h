// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/round/fit.h"
#include "vision/round/model/window.h"

namespace panelcal::internal {

/// Deviation of a piece of a rim from the fitted rim, with its uncertainty.
struct RimDeviation {
  double px = 0;        ///< outwards
  double variance = 0;  ///< by noise, px^2; 0: nothing is seen there
};

/// Deviations of 48 equal sectors, by angle.
///
/// In     window: collected about the parameters without exclusions
std::vector<RimDeviation> rim_deviations(const RimWindow& window,
                                         const RimVector& parameters,
                                         const RimNoise& noise);

}  // namespace panelcal::internal
