// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace panelcal {

/// The chance that a standard normal variable exceeds z; right far out in the tail.
double normal_exceedance(double z);

/// The z that a standard normal variable exceeds with this chance, 0 < chance < 1; what lies beyond
/// the numbers of a double counts as 37 or -37.
///
/// Source Abramowitz and Stegun 26.2.23 as a start, then Halley's iteration
double normal_of_exceedance(double chance);

/// The z that is as far out as something with these chances of less and of more; computed from the
/// smaller one, so that no digits are lost.
double normal_score(double chance_of_less, double chance_of_more);

/// The chance that the ratio of two estimates of one variance, with the given degrees of freedom,
/// exceeds a value (Snedecor's F). dof_below may be infinite: a chi-square variable's share.
///
/// Source DLMF 8.17.22 (continued fraction of the incomplete beta function), by Lentz's method
double variance_ratio_exceedance(double ratio, double dof_above, double dof_below);

/// The value that a chi-square variable exceeds with this chance, 0 < chance < 1; degrees of
/// freedom above 0 need not be whole.
///
/// Source DLMF 8.11.4 (series of the incomplete gamma function), by bisection
double chi_square_of_exceedance(double chance, double degrees_of_freedom);

/// The chance that |e| exceeds a radius, e ~ N(mean, cov) in one or two dimensions, all in one
/// unit.
///
///   P(|e| <= r) = int phi((x - m1) / s1) [Phi((c - m2) / s2) - Phi((-c - m2) / s2)] dx / s1,
///   c = sqrt(r^2 - x^2), along the principal axes
///
/// For a mean of zero calib/correction/breaking_probability.h is faster and right much farther out.
/// Out    0 to 1, to 1e-9; 1 where a number is not finite
double exceedance_about(const Eigen::VectorXd& mean, const Eigen::MatrixXd& cov, double radius);

}  // namespace panelcal
