// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/chi_square.h"

#include <algorithm>
#include <cmath>

#include "calib/base/statistics/distributions.h"

namespace panelcal {
namespace {

/// From here on the sum over Poisson's weights is left for Abdel-Aty's normal form, which is right
/// to 1 % of the root there, and takes no longer for larger values.
constexpr double kLargeChiSquare = 500;

/// The argument at which a monotonic function changes its sign; `high` grows until it has.
template <class Function>
double sign_change(Function is_beyond, double high) {
  while (!is_beyond(high)) high *= 2;
  double low = 0;
  for (int i = 0; i < 100 && low < high; ++i) {
    const double middle = low + (high - low) / 2;
    (is_beyond(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace

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

double chi_square_limit(double probability, int degrees_of_freedom) {
  return sign_change(
      [&](double x) { return chi_square_exceedance(x, degrees_of_freedom) <= probability; },
      degrees_of_freedom);
}

double noncentral_chi_square_exceedance(double chi_square,
                                        int degrees_of_freedom,
                                        double noncentrality) {
  if (chi_square <= 0) return 1;
  const double half = chi_square / 2;
  const double mean = noncentrality / 2;
  // Weights beyond are below 1e-16 of the whole.
  const int n_terms = static_cast<int>(mean + 10 * std::sqrt(mean) + 40);
  double sum = 0;
  double tail = chi_square_exceedance(chi_square, degrees_of_freedom);
  for (int j = 0; j < n_terms; ++j) {
    const double log_weight =
        mean > 0 ? j * std::log(mean) - mean - std::lgamma(j + 1.0) : (j == 0 ? 0 : -INFINITY);
    sum += std::exp(log_weight) * tail;
    const double a = degrees_of_freedom / 2.0 + j;
    tail = std::min(1.0, tail + std::exp(a * std::log(half) - half - std::lgamma(a + 1)));
  }
  return std::min(sum, 1.0);
}

double noticed_noncentrality(double false_alarm, double power, int degrees_of_freedom) {
  const double limit = chi_square_limit(false_alarm, degrees_of_freedom);
  return sign_change(
      [&](double noncentrality) {
        return noncentral_chi_square_exceedance(limit, degrees_of_freedom, noncentrality) >= power;
      },
      10);
}

double largest_noncentrality(double chi_square, int degrees_of_freedom, double chance) {
  const double most = chi_square + degrees_of_freedom;
  if (chi_square < kLargeChiSquare) {
    const auto is_beyond = [&](double noncentrality) {
      return noncentral_chi_square_exceedance(chi_square, degrees_of_freedom, noncentrality) >=
             1 - chance;
    };
    return is_beyond(0) ? 0 : sign_change(is_beyond, most);
  }
  const double z = normal_of_exceedance(1 - chance);  // below zero
  return sign_change(
      [&](double noncentrality) {
        const double mean = degrees_of_freedom + noncentrality;
        const double variance = 2 * (mean + noncentrality) / (9 * mean * mean);
        return mean * std::pow(1 - variance + z * std::sqrt(variance), 3) >= chi_square;
      },
      most);
}

}  // namespace panelcal
