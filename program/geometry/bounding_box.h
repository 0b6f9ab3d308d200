// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "calib/base/frames.h"
#include <Eigen/Core>

namespace panelcal {

/// The smallest upright rectangle around positions in frame F; positions that are not finite are
/// left out.
template <class F>
class BoundingBox {
 public:
  /// A NaN is not less than what is there, in this order of the operands.
  void add(const Position<F>& p) {
    low_mm_ = low_mm_.cwiseMin(p.in_mm());
    high_mm_ = high_mm_.cwiseMax(p.in_mm());
  }

  bool is_empty() const { return !(low_mm_.x() <= high_mm_.x()) || !(low_mm_.y() <= high_mm_.y()); }
  /// The corners. Precondition: !is_empty()
  Position<F> low() const { return position_mm<F>(low_mm_); }
  Position<F> high() const { return position_mm<F>(high_mm_); }

 private:
  static constexpr double kFar = std::numeric_limits<double>::infinity();

  Eigen::Vector2d low_mm_ = Eigen::Vector2d::Constant(kFar);
  Eigen::Vector2d high_mm_ = Eigen::Vector2d::Constant(-kFar);
};

}  // namespace panelcal
