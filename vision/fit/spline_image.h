// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace panelcal::internal {

/// Rows of numbers without gaps.
struct Raster {
  int width = 0;
  int height = 0;
  std::vector<double> values;

  Raster() = default;
  Raster(int w, int h, double value = 0)
      : width(w),
        height(h),
        values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), value) {}
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
  double at(int x, int y) const { return values[index(x, y)]; }
  double& at(int x, int y) { return values[index(x, y)]; }
};

/// Coefficients whose cubic B-spline passes through the values; mirrored at the border.
///
/// Its own transpose but for the outermost few pixels.
///
/// Source Unser, Aldroubi and Eden 1993 (recursive filter)
Raster spline_coefficients(const Raster& values);

/// The four basis splines around a place, and their slopes.
struct SplineWeights {
  int first = 0;  ///< of the four pixels
  std::array<double, 4> value;
  std::array<double, 4> slope;

  explicit SplineWeights(double at) {
    const double floor = std::floor(at);
    first = static_cast<int>(floor) - 1;
    const double t = at - floor;
    const double s = 1 - t;
    value = {s * s * s / 6,
             (4 - 6 * t * t + 3 * t * t * t) / 6,
             (4 - 6 * s * s + 3 * s * s * s) / 6,
             t * t * t / 6};
    slope = {-0.5 * s * s, t * (1.5 * t - 2), s * (2 - 1.5 * s), 0.5 * t * t};
  }
};

/// A value with its gradient, per px.
struct SplineValue {
  double value = 0;
  double dx = 0;
  double dy = 0;
};

/// A picture between its pixels: an interpolating cubic B-spline with exact derivatives.
///
/// See    tests/vision/fit/spline_image_test.cc
class SplineImage {
 public:
  SplineImage() = default;
  explicit SplineImage(const Raster& values) : coefficients_(spline_coefficients(values)) {}

  int width() const { return coefficients_.width; }
  int height() const { return coefficients_.height; }

  /// True if all sixteen pixels around a place exist.
  bool covers(const Eigen::Vector2d& at) const {
    return at.x() >= 1 && at.y() >= 1 && at.x() < width() - 2 && at.y() < height() - 2;
  }
  /// Precondition: covers the place that the weights are of.
  SplineValue operator()(const SplineWeights& x, const SplineWeights& y) const {
    SplineValue result;
    const double* row = coefficients_.values.data() + coefficients_.index(x.first, y.first);
    for (std::size_t j = 0; j < 4; ++j, row += coefficients_.width) {
      double value = 0;
      double slope = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        value += x.value[i] * row[i];
        slope += x.slope[i] * row[i];
      }
      result.value += y.value[j] * value;
      result.dx += y.value[j] * slope;
      result.dy += y.slope[j] * value;
    }
    return result;
  }
  /// Places outside are moved to the border.
  SplineValue operator()(const Eigen::Vector2d& at) const {
    return (*this)(SplineWeights(std::clamp(at.x(), 1.0, width() - 2.001)),
                   SplineWeights(std::clamp(at.y(), 1.0, height() - 2.001)));
  }

 private:
  Raster coefficients_;
};

}  // namespace panelcal::internal
