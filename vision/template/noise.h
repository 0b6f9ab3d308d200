// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "vision/template/model.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// Expected products of the noise of a template between its pixels: white noise of variance 1,
/// interpolated, times the same noise smoothed as TemplateModel::smooth is where there is
/// structure. Along one axis; in two they multiply.
class TemplateNoiseTable {
 public:
  struct Products {
    double raw_raw = 0;  ///< the variance after interpolation
    double raw_smooth = 0;
    double raw_slope = 0;      ///< with the smooth one's derivative, per px
    double raw_curvature = 0;  ///< with its second difference
    double slope_slope = 0;    ///< of the derivatives of both
    double curvature_curvature = 0;
  };

  TemplateNoiseTable();

  /// In     at: a place in the template; only its fraction matters
  const Products& operator()(double at) const {
    return table_[static_cast<std::size_t>((at - std::floor(at)) * kSteps + 0.5)];
  }

 private:
  static constexpr int kSteps = 64;
  std::array<Products, kSteps + 1> table_;
};

}  // namespace panelcal::internal
