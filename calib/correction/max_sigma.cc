// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/max_sigma.h"

#include "calib/correction/error_budget.h"

namespace panelcal {

bool MaxSigma::add_exactly(const Eigen::Matrix2d& cov_mm2) {
  if (cov_mm2 == cov_mm2_) return false;  // of a mere offset, and without a correction, all are
  const Length sigma = largest_sigma(cov_mm2);
  if (!(sigma > sigma_)) return false;
  sigma_ = sigma;
  cov_mm2_ = cov_mm2;
  constexpr double kShare = 1 - 1e-9;
  bound_mm2_ = kShare * sigma.in_mm() * sigma.in_mm();
  return true;
}

}  // namespace panelcal
