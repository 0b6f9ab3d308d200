// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "tests/bench/locate/scene.h"

namespace panelcal::bench {

/// The second moments of board texture as stationary coloured noise, measured on renderings.
class Texture {
 public:
  /// Averages the autocovariance of `n` pictures of bare board, 640 x 480, random place and seed.
  ///
  /// In     max_lag_px: covariance at larger lags is not measured
  Texture(const Condition& condition, int max_lag_px, int n, std::uint64_t seed);

  /// Texture without correlation, to check solvers.
  static Texture white(double sigma, int max_lag_px);

  double sigma() const;  ///< grey levels
  double covariance(int dx, int dy) const;
  int max_lag_px() const { return max_lag_px_; }

  /// T v for a square window of side max_lag + 1 at most, by FFT. The circulant that T is embedded
  /// in need not be positive: the weave is correlated over any distance. T is.
  Eigen::VectorXd times(const Eigen::VectorXd& v, int side_px) const;

 private:
  Texture() = default;
  void embed();
  std::size_t index(int dx, int dy) const;

  int max_lag_px_ = 0;
  std::vector<double> covariance_;  ///< dy, dx from -max_lag to max_lag
  int padded_ = 0;
  std::vector<double> spectrum_;  ///< eigenvalues of the embedding, padded x padded
};

}  // namespace panelcal::bench
