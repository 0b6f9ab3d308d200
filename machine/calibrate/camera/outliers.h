// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "calib/camera/fit/fit.h"
#include "machine/look/mark_sights.h"

namespace panelcal::internal {

/// Degrees of freedom that a scatter is judged by; with fewer, chance would enlarge it.
inline constexpr int kFewestFreedoms = 8;

/// Residuals beyond count by their length; costs honest noise 5 % of its weight.
inline constexpr double kHuberSigmas = 1.35;

/// The form that leaves the least scatter for its degrees of freedom, kFewestFreedoms or more, or
/// else the stiffest that can be fitted at all.
///
/// Fails  as fit_camera
Expected<CameraFit> least_scattered_camera(const CameraData& data, CameraFitOptions options);

/// Moves observations that do not fit the others from `sights.data.seen` to `sights.missed`, and
/// says how many.
///
/// A fit with a Huber loss, which such observations hardly bend, tells them: farther off than five
/// standard deviations, those of the detector or of what the median scatters, whichever is more.
/// Nothing is left out of so few that their scatter says nothing.
///
/// Fails  as fit_camera
/// See    tests/machine/calibrate/camera/run_test.cc
Expected<int> leave_out_outliers(const CameraFitOptions& options, MarkSights& sights);

}  // namespace panelcal::internal
