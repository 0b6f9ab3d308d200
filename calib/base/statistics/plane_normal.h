// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/statistics/random.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// Two standard normal numbers, y drawn before x: arguments of one call have no order, and
/// compilers differ in it.
inline Eigen::Vector2d plane_normal(Random& random) {
  const double y = random.normal();
  const double x = random.normal();
  return {x, y};
}

}  // namespace panelcal::internal
