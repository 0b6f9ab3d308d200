// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

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

/// Weighs strengths by the restricted likelihood of z, times a prior: a tenth that the panel is not
/// bent at all, the rest with the density u^(-1/2) (1 - u)^(-3/4) / 5.244 of u, the mean of the
/// shrinkages and the share of the data that a bending takes up: a Beta distribution.
///
/// With d that are alike the prior of s has the tail s^(-5/4). f equations of a bending far beyond
/// the noise then give its strength f + 1/2 degrees of freedom, and 95 % ellipses (below) hold
/// 1 - 0.05^(f / (f + 1/2)), 93.7 % for f = 6. A u that is uniform has s^-2, which takes such a
/// bending for smaller than it shows, a half-Cauchy distribution of sqrt(s) has s^(-3/2), 92.3 %.
///
/// In     z: whitened; d: not negative, in the same order, not all zero
/// Source Harville 1974 (restricted likelihood); Polson and Scott 2012 (inverted beta priors)
/// See    tests/calib/panel/smoothing_test.cc
Smoothing weigh_strengths(const Eigen::VectorXd& z, const Eigen::VectorXd& d);

/// The factor by which a mean bending has to grow for an ellipse that holds 95 % of all bendings.
///
///   sum of w_k P(|e_k|^2 in the ellipse of (noise + growth mean(bent))) = 0.95
///
/// with e_k ~ N(0, noise + bent_k), whose form is taken for that of the ellipse. Few equations tell
/// a bending's strength badly: its errors are then distributed like Student's t, and 95 % of them
/// lie farther out than their variance says. Strengths of an inverse gamma distribution of f
/// degrees of freedom, and no noise, give (f - 2) (0.05^(-2 / f) - 1) / 5.991, Hotelling's factor
/// (misfit.h) over the variance's.
///
/// In     noise, bent: mm^2, of one place; weight: of each strength, the sum is 1
/// Out    1 or more: a mixture whose 95 % lie nearer keeps its variance
double growth_to_95_percent(const Eigen::Matrix2d& noise,
                            std::span<const Eigen::Matrix2d> bent,
                            const Eigen::VectorXd& weight);

}  // namespace panelcal::internal
