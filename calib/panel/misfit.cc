// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/misfit.h"

#include "calib/base/statistics/chi_square.h"

namespace panelcal::internal {

double misfit_excess(double chi_square, int degrees_of_freedom) {
  if (degrees_of_freedom < 1) return 0;
  // Written so that what is no number rejects, and makes the covariance no number.
  if (chi_square_exceedance(chi_square, degrees_of_freedom) >= kMisfitChance) return 0;
  return chi_square / degrees_of_freedom - 1;
}

void count_misfit(double excess, RawSmooth& smooth) {
  smooth.misfit = {excess * (smooth.cov.xx - smooth.choice.xx),
                   excess * (smooth.cov.xy - smooth.choice.xy),
                   excess * (smooth.cov.yy - smooth.choice.yy)};
  smooth.cov += smooth.misfit;
}

}  // namespace panelcal::internal
