// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/max_sigma.h"

#include "calib/correction/error_budget.h"

namespace panelcal {

bool MaxSigma::add_exactly(const Eigen::Matrix2d& cov_mm2) {
  if (cov_mm2.isZero(0)) return false;  // without a correction every one is
  const Length sigma = largest_sigma(cov_mm2);
  if (!(sigma > sigma_)) return false;
  sigma_ = sigma;
  variance_mm2_ = sigma.in_mm() * sigma.in_mm();
  return true;
}

}  // namespace panelcal
