// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/misfit.h"

#include <cmath>

#include "calib/base/statistics/chi_square.h"

namespace panelcal::internal {

double misfit_excess(double chi_square, int degrees_of_freedom) {
  if (degrees_of_freedom < 1) return 0;
  const bool estimates_noise = degrees_of_freedom >= kScatterEquations;
  const double chance = estimates_noise ? kScatterChance : kMisfitChance;
  // Written so that what is no number rejects, and makes the covariance no number.
  if (chi_square_exceedance(chi_square, degrees_of_freedom) >= chance) return 0;
  const double f = degrees_of_freedom;
  constexpr double kEllipse = 5.991464547107979;  // -2 ln 0.05
  const double of_estimate = estimates_noise ? f * (std::pow(0.05, -2 / f) - 1) / kEllipse : 1;
  return of_estimate * chi_square / f - 1;
}

void count_misfit(double excess, RawSmooth& smooth) {
  smooth.misfit = {excess * (smooth.cov.xx - smooth.choice.xx),
                   excess * (smooth.cov.xy - smooth.choice.xy),
                   excess * (smooth.cov.yy - smooth.choice.yy)};
  smooth.cov += smooth.misfit;
}

}  // namespace panelcal::internal
