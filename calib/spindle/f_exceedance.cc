// SPDX-License-Identifier: Apache-2.0
#include "calib/spindle/f_exceedance.h"

#include <algorithm>
#include <cmath>

#include "calib/base/statistics/chi_square.h"

namespace panelcal {

double f_exceedance(double f, int numerator, double denominator) {
  if (std::isnan(f) || std::isnan(denominator)) return std::nan("");
  if (f <= 0) return 1;
  if (std::isinf(f)) return 0;
  if (std::isinf(denominator)) return chi_square_exceedance(f * numerator, numerator);
  const double half = denominator / 2;
  const double rest = 1 / (1 + denominator / (numerator * f));  // 1 - y
  double term = 1;
  double sum = 0;
  for (int j = 0; j < numerator / 2; ++j) {
    sum += term;
    term *= (half + j) / (j + 1) * rest;
  }
  return std::min(1.0, std::exp(half * std::log1p(-rest)) * sum);
}

}  // namespace panelcal
