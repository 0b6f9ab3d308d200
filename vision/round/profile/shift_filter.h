// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/round/profile/step_profile.h"
#include "vision/round/profile/strip.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The best linear measure of how far a piece of a rim lies outwards.
///
///   shift = weights . (levels of the rings, the median of each taken off)
///
/// Generalised least squares for white noise and texture as the strip's own flat rings show them;
/// blind to what raises all of the inside, all of the surroundings, or tilts the light.
struct ShiftFilter {
  Eigen::VectorXd weights;  ///< px per grey level, by ring
  double variance = 0;      ///< of one sector's shift, for slow changes along the rim, px^2
};

/// Single cells that are far off, dust and scratches, count as if they were at a limit.
///
/// In     left: the strip less each ring's median
/// Source Aitken 1936
ShiftFilter make_shift_filter(const RimStrip& strip,
                              const Eigen::ArrayXXf& left,
                              const StepProfile& step);

/// The same for nothing but white noise, of the given variance of a pixel, in the rings there are.
ShiftFilter make_plain_filter(const RimStrip& strip, const StepProfile& step, double variance);

/// Filter for the extra blur of a piece of a rim, px of the edge's sigma: blind to its place as
/// well.
ShiftFilter make_blur_filter(const RimStrip& strip, const StepProfile& step, double variance);

/// The largest shift, px, that a filter may show for what the mean profile has beyond a step: bands
/// along the edge, of a lamp on its slope or of a camera that sharpens.
///
/// In     medians: levels of the strip's rings
double band_shift(const RimStrip& strip,
                  const Eigen::ArrayXd& medians,
                  const StepProfile& step,
                  const ShiftFilter& filter);

}  // namespace panelcal::internal
