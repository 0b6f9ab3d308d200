// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "panelcal/calib/base/frames.h"

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
  PositionEstimate<To> operator()(const Position<From>& p) const {
    const Eigen::Vector2d& v = internal::raw(p);
    Eigen::Matrix<double, 2, 6> j;
    j << v.x(), v.y(), 0, 0, 1, 0, 0, 0, v.x(), v.y(), 0, 1;
    return {map(p), j * cov * j.transpose()};
  }
};

/// First-order propagation: covariance of f(p) from the covariance of p and the Jacobian of f.
inline Eigen::Matrix2d propagate(const Eigen::Matrix2d& jacobian, const Eigen::Matrix2d& cov) {
  return jacobian * cov * jacobian.transpose();
}

}  // namespace panelcal
