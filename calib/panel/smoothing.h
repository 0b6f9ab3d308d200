// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace panelcal::internal {

/// Possible strengths of a panel's bending, each with its weight.
///
/// In coordinates where both are diagonal, what an affine map leaves of the data is
///
///   z_j ~ N(0, 1 + s d_j),   1 from the noise, s d_j from a bending of strength s
struct Smoothing {
  Eigen::VectorXd strength;   ///< s, growing from 0: an affine panel
  Eigen::VectorXd weight;     ///< of each; the sum is 1
  Eigen::MatrixXd shrinkage;  ///< s d_j / (1 + s d_j): what of z_j is taken for bending; j x k

  Eigen::VectorXd mean_shrinkage() const { return shrinkage * weight; }
  Eigen::VectorXd shrinkage_variance() const;
};

/// Weighs strengths by the restricted likelihood of z, times a prior: one fifth that the panel is
/// not bent at all, the rest uniform in the mean of the shrinkages, the share of the data that
/// a bending takes up.
///
/// In     z: whitened; d: not negative, in the same order, not all zero
/// Source Harville 1974 (restricted likelihood); Daniels 1999 (uniform shrinkage prior)
Smoothing weigh_strengths(const Eigen::VectorXd& z, const Eigen::VectorXd& d);

}  // namespace panelcal::internal
