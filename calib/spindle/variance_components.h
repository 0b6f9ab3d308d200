// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

// Not installed: the random-effects model under calib/spindle/fit.h.
namespace panelcal::internal {

/// One observation of a place, of those that belong to one thing (the views of a hole).
struct GroupedObservation {
  int group = 0;  ///< from 0; every group up to the greatest has an observation
  Eigen::Vector2d value_mm = Eigen::Vector2d::Zero();
  Eigen::Matrix2d cov_mm2 = Eigen::Matrix2d::Zero();  ///< of the part of the noise that is known
  Eigen::Matrix<double, 2, Eigen::Dynamic> design;    ///< by the fixed effects
};

/// Choice of the variances that are estimated.
struct VarianceModel {
  bool has_within = true;  ///< false: one variance stands for both
  bool per_axis = false;   ///< x and y have their own
};

/// A variance along x and along y (equal unless per_axis) with the standard errors of each. Where
/// the data want a negative one it is zero, and the standard error says how large it might be.
struct VarianceEstimate {
  Eigen::Vector2d value_mm2 = Eigen::Vector2d::Zero();
  Eigen::Vector2d error_mm2 = Eigen::Vector2d::Zero();
};

/// Deviation of one group from the fixed effects.
struct GroupDeviation {
  Eigen::Vector2d mean_mm = Eigen::Vector2d::Zero();  ///< weighted mean of values minus fixed
  Eigen::Matrix2d cov_mm2 = Eigen::Matrix2d::Zero();  ///< of that mean about zero
};

struct MixedFit {
  VarianceModel model;
  Eigen::VectorXd fixed;               ///< mm per unit of each column
  Eigen::MatrixXd cov;                 ///< of them, mm^2, as if the variances were known
  Eigen::VectorXd degrees_of_freedom;  ///< of the variance of each; infinite if nothing is unknown
  Eigen::MatrixXd gain;                ///< d fixed / d values (x0 y0 x1 ..)
  VarianceEstimate between;
  VarianceEstimate within;
  std::vector<GroupDeviation> groups;
  double chi_square = 0;  ///< of all residuals against the fitted variances
  int n_free = 0;         ///< scalar observations minus fixed effects
  double log_likelihood = 0;

  /// Covariance of the first n fixed effects that is right in the mean although the variances are
  /// estimated; empty if they are not known well enough for a second moment to exist.
  ///
  ///   error^2 / estimated variance ~ F(., nu),   whose mean is nu / (nu - 2)
  std::optional<Eigen::MatrixXd> honest_cov(int n) const;
};

/// Fits fixed effects and the variances of groups and within groups.
///
///   value_gv = design_gv fixed + a_g + r_gv + e_gv
///   a_g ~ N(0, between)   r_gv ~ N(0, within)   e_gv ~ N(0, cov_gv), known
///
/// The variances maximise the restricted likelihood, which pays for the fixed effects that are
/// fitted as well: for balanced data it gives the unbiased estimates of an analysis of variance.
/// Fisher's scoring with the variances kept from being negative; then generalised least squares.
/// Each fixed effect's variance has the degrees of freedom of the estimate it is made of
/// (Satterthwaite 1946), from the expected information of the variances.
///
/// Out    empty if a number is not finite, a covariance is not positive definite, the fixed effects
///        are not determined or nothing is left to judge the variances by
/// Cost   O(sum over groups of views^3) an iteration
/// Source Patterson and Thompson 1971 (REML); Searle, Casella and McCulloch 1992, 6.6 and 7.4;
///        Giesbrecht and Burns 1985 (degrees of freedom)
/// See    tests/calib/spindle/variance_components_test.cc
std::optional<MixedFit> fit_mixed(std::span<const GroupedObservation> observations,
                                  const VarianceModel& model);

/// The fixed effects where the variances are told, not fitted; standard errors of variances are 0.
///
/// Out    as fit_mixed
std::optional<MixedFit> fit_fixed(std::span<const GroupedObservation> observations,
                                  double between_mm2,
                                  double within_mm2);

/// Deviation from the fit of a group that took no part in it; the covariance is that of the mean
/// under the fitted variances and of the fixed effects together.
///
/// Precondition: group has one observation or more, with as many columns as the fit
GroupDeviation deviation_of_other(const MixedFit& fit, std::span<const GroupedObservation> group);

}  // namespace panelcal::internal
