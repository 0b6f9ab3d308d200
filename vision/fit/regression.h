// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

// Not installed.
namespace panelcal::internal {

/// Sums over pixels for the straight line of what is seen against what a model predicts.
///
///   seen = gain * model + offset
struct Regression {
  double n = 0;
  double m = 0;  ///< of the model
  double v = 0;  ///< of what is seen
  double mm = 0;
  double mv = 0;
  double vv = 0;

  void add(double model, double seen) {
    ++n;
    m += model;
    v += seen;
    mm += model * model;
    mv += model * seen;
    vv += seen * seen;
  }
  /// Sums of squares and of products about the means.
  double model_square() const { return mm - m * m / std::max(1.0, n); }
  double seen_square() const { return vv - v * v / std::max(1.0, n); }
  double product() const { return mv - m * v / std::max(1.0, n); }
  /// Precondition: model_square() > 0.
  double gain() const { return product() / model_square(); }

  /// The correlation of model and picture, 0 to 1, without noise of this variance, which counts for
  /// three quarters of what is seen at most; 0 where either is flat.
  double correlation(double noise_variance) const {
    const double shown = std::max(seen_square() - n * noise_variance, 0.25 * seen_square());
    if (!(model_square() > 0) || !(shown > 0)) return 0;
    return std::clamp(product() / std::sqrt(model_square() * shown), 0.0, 1.0);
  }
};

}  // namespace panelcal::internal
