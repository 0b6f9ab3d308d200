// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "panelcal/vision/fit_frame.h"
#include "panelcal/vision/image.h"
#include "panelcal/vision/locate.h"
#include "panelcal/vision/rim_rays.h"

namespace panelcal::internal {

/// A candidate after its fit, and what speaks against it.
struct FittedCandidate {
  enum class Verdict {
    Good,
    Unfit,     ///< surely there, but not the target asked for: wrong size, at the border
    Unlikely,  ///< too faint or too little like the target to be called one
  };

  Verdict verdict = Verdict::Unlikely;
  std::string reason;
  TargetFit fit;
};

/// Fits the model to the pixels around a rim and judges the result.
///
/// A Huber fit to all pixels, then twice a plain fit without those that it cannot explain, then
/// one weighted by the noise on and around the target.
FittedCandidate fit_candidate(const Image& image,
                              const FitFrame& fit_frame,
                              const ExpectedRim& expected,
                              const RimStart& start,
                              const LocateOptions& options);

}  // namespace panelcal::internal
