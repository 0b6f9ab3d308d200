// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

// Not installed.
namespace panelcal::internal {

/// log |Gamma(x)| for several threads: std::lgamma leaves the sign in a variable that they share.
inline double log_gamma(double x) {
  int sign = 0;
  return ::lgamma_r(x, &sign);
}

}  // namespace panelcal::internal
