// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "calib/camera/fit/fit.h"
#include "machine/look/mark_sights.h"

namespace panelcal::internal {

/// Residuals beyond count by their length; costs honest noise 5 % of its weight.
inline constexpr double kHuberSigmas = 1.35;

/// Moves observations that do not fit the others from `sights.data.seen` to `sights.missed`, and
/// says how many.
///
/// A fit with a Huber loss, which such observations hardly bend, names suspects: farther off than
/// five standard deviations of what is stated and of the variance that all looks scatter beyond it
/// (fit_scattered_robustly()). That of a few looks is uncertain itself, so suspects are then held
/// against the fit of the others (F test, its chance multiplied by the number of ways to choose as
/// many, with as little and as much scatter as the others allow): one in a thousand calibrations
/// without outliers loses a look. The form is the softest that the views determine, whichever is
/// fitted afterwards: what it cannot follow is no lens.
///
/// Fails  as fit_camera
/// See    tests/machine/calibrate/camera/scatter_test.cc
Expected<int> leave_out_outliers(const CameraFitOptions& options, MarkSights& sights);

}  // namespace panelcal::internal
