// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/base/units.h"

namespace panelcal {

/// The prediction of the other probes at the place of one probe.
struct LeftOutProbe {
  std::optional<Length> deviation;  ///< measured minus predicted; empty: the others predict nothing
  Length sigma;                     ///< of that, the probe's own scatter included
  double chance = 1;                ///< that a good probe deviates more
};

}  // namespace panelcal
