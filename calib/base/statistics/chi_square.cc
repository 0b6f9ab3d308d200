// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/chi_square.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "calib/base/statistics/distributions.h"
#include "calib/base/statistics/log_gamma.h"

namespace panelcal {
namespace {

/// From here on the sum over Poisson's weights is left for Abdel-Aty's normal form, which is right
/// to 1 % of the root there, and takes no longer for larger values.
constexpr double kLargeChiSquare = 500;

/// log Gamma(n / 2) for n of 1 or more: series ask for the same ones again and again.
double log_gamma_of_half(int n) {
  static const auto known = [] {
    std::array<double, 1024> values{};
    for (std::size_t i = 1; i < values.size(); ++i) {
      values[i] = internal::log_gamma(static_cast<double>(i) / 2);
    }
    return values;
  }();
  const auto i = static_cast<std::size_t>(n);
  return i < known.size() ? known[i] : internal::log_gamma(n / 2.0);
}

/// The argument at which a monotonic function changes its sign; `high` grows until it has.
template <class Function>
double sign_change(Function is_beyond, double high) {
  while (!is_beyond(high)) high *= 2;
  double low = 0;
  for (int i = 0; i < 100 && low < high; ++i) {
    const double middle = low + (high - low) / 2;
    if (middle == low || middle == high) break;
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
  const double log_half = std::log(half);
  // Terms half^a e^-half / Gamma(a + 1), through logarithms so that nothing overflows.
  for (int twice_a = is_odd ? 1 : 0; twice_a < degrees_of_freedom; twice_a += 2) {
    sum += std::exp(twice_a / 2.0 * log_half - half - log_gamma_of_half(twice_a + 2));
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
  const double log_half = std::log(half);
  const double log_mean = std::log(mean);
  // Weights beyond are below 1e-16 of the whole.
  const int n_terms = static_cast<int>(mean + 10 * std::sqrt(mean) + 40);
  double sum = 0;
  double tail = chi_square_exceedance(chi_square, degrees_of_freedom);
  for (int j = 0; j < n_terms; ++j) {
    const double log_weight =
        mean > 0 ? j * log_mean - mean - log_gamma_of_half(2 * j + 2) : (j == 0 ? 0 : -INFINITY);
    sum += std::exp(log_weight) * tail;
    const int twice_a = degrees_of_freedom + 2 * j;
    const double log_term = twice_a / 2.0 * log_half - half - log_gamma_of_half(twice_a + 2);
    tail = std::min(1.0, tail + std::exp(log_term));
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
