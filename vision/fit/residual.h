// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "calib/base/statistics/median.h"

// Not installed. What a pixel's residual says, whatever the model.
namespace panelcal::internal {

/// True if a clipped pixel tells nothing more: the model is beyond the scale's end as well.
inline bool is_beyond_scale(double value, double level, double full_scale) {
  return (value >= full_scale && level >= full_scale) || (value <= 0 && level <= 0);
}

/// Cost and weight of a residual; residuals of more than `huber` sigmas count linearly, 0: none do.
struct RobustTerm {
  double cost = 0;
  double weight = 1;

  /// In     variance_weight: 1 / variance of the residual
  RobustTerm(double residual, double variance_weight, double huber) : weight(variance_weight) {
    const double z = std::abs(residual) * std::sqrt(variance_weight);
    const bool is_far = huber > 0 && z > huber;
    cost = is_far ? huber * (2 * z - huber) : z * z;
    if (is_far) weight *= huber / z;
  }
};

/// Sigma of the noise that differs from pixel to pixel: by the median difference of neighbours.
///
/// In     pixels: with places x and y, by rows; value_of: the value of the one of an index
template <class Pixel, class ValueOf>
double white_noise_of(const std::vector<Pixel>& pixels, ValueOf&& value_of) {
  std::vector<double> differences;
  differences.reserve(pixels.size());
  for (std::size_t i = 1; i < pixels.size(); ++i) {
    const Pixel& a = pixels[i - 1];
    const Pixel& b = pixels[i];
    if (a.y == b.y && a.x + 1 == b.x) {
      differences.push_back(std::abs(value_of(i) - value_of(i - 1)));
    }
  }
  return kSigmasPerMedian / std::sqrt(2.0) * median(std::move(differences));
}

}  // namespace panelcal::internal
