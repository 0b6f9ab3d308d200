// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include "panelcal/calib/base/frames.h"
#include "panelcal/calib/base/units.h"

namespace panelcal::test {

/// Matches a position within `tolerance` of `expected`; never matches NaN.
MATCHER_P2(IsNearPosition, expected, tolerance, "") {
  const double distance_mm = (arg.in_mm() - expected.in_mm()).norm();
  *result_listener << "(" << arg.in_mm().x() << ", " << arg.in_mm().y() << ") mm is "
                   << distance_mm * 1e3 << " um from (" << expected.in_mm().x() << ", "
                   << expected.in_mm().y() << ") mm, tolerance " << tolerance.in_um() << " um";
  return distance_mm <= tolerance.in_mm();
}

}  // namespace panelcal::test
