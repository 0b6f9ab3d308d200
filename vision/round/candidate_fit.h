// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/fit/detector.h"
#include "vision/fit/frame.h"
#include "vision/round/estimate.h"
#include "vision/round/rays.h"

// Not installed.
namespace panelcal::internal {

/// A rim after its fit.
struct RimFit {
  FitFrame fit_frame;
  RimStart start;
  RimEstimate estimate;  ///< of a rim at the border or of few pixels, which is not fitted: none
  TargetFit target;

  bool is_too_small() const;
};

/// Fits the model to the pixels around a rim.
///
/// A rough fit to some of the rows; one to all pixels; then, if the residuals say so, again without
/// neighbours and debris, with an oval rim, or with the ground's texture as correlated noise.
RimFit fit_candidate(const DetectorInput& input,
                     const FitFrame& fit_frame,
                     const ExpectedRim& expected,
                     const RimStart& start);

Judgement judge_rim(const DetectorInput& input, const ExpectedRim& expected, const RimFit& fit);

}  // namespace panelcal::internal
