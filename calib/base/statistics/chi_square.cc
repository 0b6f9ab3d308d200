// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/chi_square.h"

#include <algorithm>
#include <cmath>

namespace panelcal {

double chi_square_exceedance(double chi_square, int degrees_of_freedom) {
  if (std::isnan(chi_square)) return chi_square;
  if (chi_square <= 0) return 1;
  if (std::isinf(chi_square)) return 0;
  const double half = chi_square / 2;
  const bool is_odd = degrees_of_freedom % 2 != 0;
  double sum = is_odd ? std::erfc(std::sqrt(half)) : 0;
  // Terms half^a e^-half / Gamma(a + 1), through logarithms so that nothing overflows.
  for (double a = is_odd ? 0.5 : 0; a < degrees_of_freedom / 2.0 - 0.25; a += 1) {
    sum += std::exp(a * std::log(half) - half - std::lgamma(a + 1));
  }
  return std::min(sum, 1.0);
}

}  // namespace panelcal
