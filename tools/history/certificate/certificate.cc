// SPDX-License-Identifier: Apache-2.0
#include "tools/history/certificate/certificate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/base/statistics/distributions.h"

namespace panelcal::history {

double Scatter::sigma() const {
  return std::sqrt(variance);
}

std::array<double, 2> Scatter::interval() const {
  constexpr double kTail = 0.025;
  const double squares = variance * degrees_of_freedom;
  const double low = chi_square_of_exceedance(kTail, degrees_of_freedom);
  const double high = chi_square_of_exceedance(1 - kTail, degrees_of_freedom);
  return {std::sqrt(squares / low),
          high > 0 ? std::sqrt(squares / high) : std::numeric_limits<double>::infinity()};
}

double GaugeStudy::reproducibility_variance() const {
  return std::max(0.0, over_nights.variance - within_variance);
}

Scatter GaugeStudy::both() const {
  const double sum = repeatability.variance + reproducibility_variance();
  // The parts are two observed variances: S^2 counts where some of it is left.
  double parts = repeatability.variance * repeatability.variance / repeatability.degrees_of_freedom;
  if (reproducibility_variance() > 0) {
    parts += over_nights.variance * over_nights.variance / over_nights.degrees_of_freedom;
  }
  return {sum, parts > 0 ? sum * sum / parts : repeatability.degrees_of_freedom};
}

std::array<double, 2> UncertaintyBudget::combined_mm() const {
  std::array<double, 2> out = {};
  for (const BudgetRow& row : rows) {
    for (std::size_t k = 0; k < 2; ++k) out[k] = std::hypot(out[k], row.sigma_mm[k]);
  }
  return out;
}

std::array<std::optional<double>, 2> UncertaintyBudget::degrees_of_freedom() const {
  const std::array<double, 2> combined = combined_mm();
  std::array<std::optional<double>, 2> out;
  for (std::size_t k = 0; k < 2; ++k) {
    double parts = 0;
    for (const BudgetRow& row : rows) {
      if (row.degrees_of_freedom) parts += std::pow(row.sigma_mm[k], 4) / *row.degrees_of_freedom;
    }
    if (parts > 0) out[k] = std::pow(combined[k], 4) / parts;
  }
  return out;
}

std::array<double, 2> UncertaintyBudget::coverage_factor() const {
  const auto degrees = degrees_of_freedom();
  return {coverage_factor_of(kCoverage, degrees[0]), coverage_factor_of(kCoverage, degrees[1])};
}

double coverage_factor_of(double coverage, const std::optional<double>& degrees_of_freedom) {
  const double beyond = 1 - coverage;
  const double normal = normal_of_exceedance(beyond / 2);
  if (!degrees_of_freedom) return normal;
  // t^2 is F with one degree of freedom above.
  const auto exceeds = [&](double t) {
    return variance_ratio_exceedance(t * t, 1, *degrees_of_freedom) > beyond;
  };
  double low = normal;
  double high = 2 * normal;
  while (exceeds(high) && high < 1e9) high *= 2;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (exceeds(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace panelcal::history
