// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/frames.h"
#include <Eigen/Core>

namespace panelcal {

/// A measured point: its value and the 2 x 2 covariance of its error (mm^2, or px^2 in a picture).
template <class F>
struct PositionEstimate {
  Position<F> position;
  Eigen::Matrix2d cov = Eigen::Matrix2d::Zero();
};

/// An affine map whose six coefficients are uncertain.
///
/// The covariance's order is [l00 l01 l10 l11 tx ty] (linear part by rows, then translation), so
/// that a mapped point is J(p) a with J(p) = [x y 0 0 1 0; 0 0 x y 0 1].
template <class To, class From>
struct TransformEstimate {
  Transform<To, From> map;
  Eigen::Matrix<double, 6, 6> cov = Eigen::Matrix<double, 6, 6>::Zero();

  /// The mapped point with the covariance that comes from the map alone; p is taken as exact.
  ///
  /// J(p) cov J(p)^T, written out without the zeros of J: every hole asks for it.
  PositionEstimate<To> operator()(const Position<From>& p) const {
    const double x = internal::raw(p).x();
    const double y = internal::raw(p).y();
    // The covariance of two coordinates of the mapped point, each with its three coefficients.
    const auto between = [this, x, y](int i, int k) {
      const auto by_row = [&](int row) {
        return x * cov(row, 2 * k) + y * cov(row, 2 * k + 1) + cov(row, 4 + k);
      };
      return x * by_row(2 * i) + y * by_row(2 * i + 1) + by_row(4 + i);
    };
    PositionEstimate<To> mapped{map(p)};
    mapped.cov(0, 0) = between(0, 0);
    mapped.cov(1, 1) = between(1, 1);
    mapped.cov(0, 1) = mapped.cov(1, 0) = between(0, 1);
    return mapped;
  }
};

/// First-order propagation: covariance of f(p) from the covariance of p and the Jacobian of f.
inline Eigen::Matrix2d propagate(const Eigen::Matrix2d& jacobian, const Eigen::Matrix2d& cov) {
  return jacobian * cov * jacobian.transpose();
}

}  // namespace panelcal
