// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/chi_square.h"

#include <algorithm>
#include <cmath>

#include "calib/base/statistics/distributions.h"

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

double chi_square_exceeded(double chance, int degrees_of_freedom) {
  double low = 0;
  double high = degrees_of_freedom;
  while (chi_square_exceedance(high, degrees_of_freedom) > chance) high *= 2;
  while (high - low > 1e-10 * high) {
    const double middle = (low + high) / 2;
    (chi_square_exceedance(middle, degrees_of_freedom) > chance ? low : high) = middle;
  }
  return (low + high) / 2;
}

double largest_noncentrality(double chi_square, int degrees_of_freedom, double chance) {
  const double z = normal_of_exceedance(1 - chance);  // below zero
  const auto quantile = [&](double lambda) {
    const double mean = degrees_of_freedom + lambda;
    const double variance = 2 * (degrees_of_freedom + 2 * lambda) / (9 * mean * mean);
    return mean * std::pow(std::max(0.0, 1 - variance + z * std::sqrt(variance)), 3);
  };
  double low = 0;
  double high = chi_square + degrees_of_freedom;
  if (!(quantile(low) < chi_square)) return 0;
  while (quantile(high) < chi_square) high *= 2;
  while (high - low > 1e-6 * high) {
    const double middle = (low + high) / 2;
    (quantile(middle) < chi_square ? low : high) = middle;
  }
  return high;
}

}  // namespace panelcal
