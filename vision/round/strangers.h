// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/round/residuals.h"
#include "vision/round/window.h"

namespace panelcal::internal {

/// Pixels that do not belong to the picture of the target alone: smoothed residuals beyond chance,
/// those above half of the largest first, and what is connected with them.
///
/// Deviations of the rim that are small beside the contrast are its own shape and stay.
///
/// Out    new pixels were excluded in the window
bool exclude_strangers(RimWindow& window,
                       const RimResiduals& residuals,
                       const RimNoiseEstimate& noise,
                       const RimVector& parameters);

/// Whether exclude_strangers() would find any.
bool has_strangers(const RimWindow& window,
                   const RimResiduals& residuals,
                   const RimNoiseEstimate& noise,
                   const RimVector& parameters);

}  // namespace panelcal::internal
