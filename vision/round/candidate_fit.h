// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/fit/detector.h"
#include "vision/fit/frame.h"
#include "vision/locate/locate.h"
#include "vision/picture/image.h"
#include "vision/round/rays.h"

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
