// SPDX-License-Identifier: Apache-2.0
#pragma once

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
    // mean + sqrt(square) is below the bound, without the root. Rounding is far below the share
    // that the bound leaves; squares that are too small for a double are as well.
    constexpr double kLeast_mm2 = 1e-100;
    const double room_mm2 = bound_mm2_ - mean_mm2;
    if (bound_mm2_ > kLeast_mm2 && room_mm2 >= 0 && square_mm4 < room_mm2 * room_mm2) return false;
    if (mean_mm2 <= 0 && square_mm4 <= 0) return false;  // zero, as all are without a correction
    return add_exactly(cov_mm2);
  }
  Length value() const { return sigma_; }

 private:
  bool add_exactly(const Eigen::Matrix2d& cov_mm2);

  Length sigma_;
  double bound_mm2_ = 0;                               ///< a little below its square
  Eigen::Matrix2d cov_mm2_ = Eigen::Matrix2d::Zero();  ///< its own
};

}  // namespace panelcal
