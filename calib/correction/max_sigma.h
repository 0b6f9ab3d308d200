// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "calib/base/units.h"
#include <Eigen/Core>

namespace panelcal {

/// The largest of very many largest_sigma() (calib/correction/error_budget.h).
///
/// See    tests/calib/correction/error_budget_test.cc
class MaxSigma {
 public:
  /// True if it is larger than all before it. Works it out only where it may be.
  bool add(const Eigen::Matrix2d& cov_mm2) {
    const double mean_mm2 = (cov_mm2(0, 0) + cov_mm2(1, 1)) / 2;
    const double half_mm2 = (cov_mm2(0, 0) - cov_mm2(1, 1)) / 2;
    const double square_mm4 = half_mm2 * half_mm2 + cov_mm2(0, 1) * cov_mm2(0, 1);
    // Rounding is far below the share; squares that are too small for a double are as well.
    constexpr double kShare = 1 + 1e-9;
    constexpr double kLeast_mm2 = 1e-100;
    if (variance_mm2_ > kLeast_mm2 &&
        (mean_mm2 + std::sqrt(square_mm4)) * kShare <= variance_mm2_) {
      return false;
    }
    return add_exactly(cov_mm2);
  }
  Length value() const { return sigma_; }

 private:
  bool add_exactly(const Eigen::Matrix2d& cov_mm2);

  Length sigma_;
  double variance_mm2_ = 0;  ///< its square, but for rounding
};

}  // namespace panelcal
