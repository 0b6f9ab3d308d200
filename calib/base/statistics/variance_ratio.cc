// SPDX-License-Identifier: Apache-2.0
// Snedecor's F of calib/base/statistics/distributions.h: it needs chi_square.h, which needs that.
#include <cmath>

#include "calib/base/statistics/chi_square.h"
#include "calib/base/statistics/distributions.h"
#include "calib/base/statistics/log_gamma.h"

namespace panelcal {
namespace {

/// The continued fraction of I_x(a, b), which converges fast for x < (a + 1) / (a + b + 2).
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300;
  constexpr double kRounding = 1e-15;
  constexpr int kMostTerms = 10000;
  const auto no_zero = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
  double c = 1;
  double d = 1 / no_zero(1 - (a + b) * x / (a + 1));
  double value = d;
  for (int m = 1; m < kMostTerms; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / no_zero(1 + even * d);
    c = no_zero(1 + even / c);
    value *= c * d;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / no_zero(1 + odd * d);
    c = no_zero(1 + odd / c);
    value *= c * d;
    if (std::abs(c * d - 1) < kRounding) break;
  }
  return value;
}

/// I_x(a, b); `rest` is 1 - x, which the caller knows better than a difference does.
double incomplete_beta(double a, double b, double x, double rest) {
  if (x <= 0) return 0;
  if (rest <= 0) return 1;
  const double front = std::exp(internal::log_gamma(a + b) - internal::log_gamma(a) -
                                internal::log_gamma(b) + a * std::log(x) + b * std::log(rest));
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1 - front * beta_fraction(b, a, rest) / b;
}

}  // namespace

double variance_ratio_exceedance(double ratio, double dof_above, double dof_below) {
  if (std::isnan(ratio)) return ratio;
  if (ratio <= 0) return 1;
  if (std::isinf(ratio)) return 0;
  if (std::isinf(dof_below)) {
    return chi_square_exceedance(dof_above * ratio, static_cast<int>(std::lround(dof_above)));
  }
  const double above = dof_above * ratio;
  const double sum = dof_below + above;
  return incomplete_beta(0.5 * dof_below, 0.5 * dof_above, dof_below / sum, above / sum);
}

}  // namespace panelcal
