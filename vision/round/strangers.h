// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/round/model/window.h"
#include "vision/round/residuals.h"

namespace panelcal::internal {

/// True if some pixels do not belong to the picture of the target alone: residuals, or their means
/// over 5 x 5 px, beyond chance.
bool has_strangers(const RimWindow& window,
                   const RimResiduals& residuals,
                   const RimNoiseEstimate& noise,
                   const RimVector& parameters);

}  // namespace panelcal::internal
