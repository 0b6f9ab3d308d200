// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "panelcal/vision/detector.h"
#include "panelcal/vision/fit_frame.h"
#include "panelcal/vision/image.h"
#include "panelcal/vision/locate.h"
#include "panelcal/vision/rim_rays.h"

namespace panelcal::internal {

/// Fits the model to the pixels around a rim and judges the result.
///
/// A rough fit to some of the rows; one to all pixels; then, if the residuals say so, again without
/// neighbours and debris, with an oval rim, or with the ground's texture as correlated noise.
FittedCandidate fit_candidate(const Image& image,
                              const FitFrame& fit_frame,
                              const ExpectedRim& expected,
                              const RimStart& start,
                              const LocateOptions& options);

}  // namespace panelcal::internal
