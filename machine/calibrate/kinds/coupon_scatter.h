// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "machine/calibrate/calibration.h"
#include "machine/calibrate/spindle/camera_run.h"

namespace panelcal {

/// The figures of a run about the drill and the lens, each with its degrees of freedom:
///
///   holes about the fit    a worn drill, a loose coupon     mean square of the holes' residuals
///   looks at a hole        a dirty lens, a loose camera     mean square about each hole's mean
///
/// Of the holes that are used; each hole's mean takes two degrees of freedom from its looks, the
/// offset two from the holes, a fitted backlash one from the looks.
inline constexpr int kMostCouponSpreads = 2;
std::vector<NightSpread> coupon_scatter(const SpindleCameraRun& run);

/// The same for the picture: where the holes lie and how far the drill went astray.
std::vector<NightHole> coupon_holes(const SpindleCameraRun& run);

}  // namespace panelcal
