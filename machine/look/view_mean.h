// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "calib/base/estimate.h"
#include "calib/base/frames.h"
#include "calib/base/machine_uncertainty.h"
#include <Eigen/Core>

// Not installed: how several looks at one target become one place.
namespace panelcal::internal {

/// The value that a chi-square of `n_free` degrees of freedom exceeds in one of a hundred cases
/// (Wilson and Hilferty 1931; within 1 % from two degrees on).
double chi_square_limit(int n_free);

/// One of the looks at a large target.
struct ViewDeviation {
  Eigen::Vector2d offset_mm;     ///< of the view from the target's middle
  Eigen::Vector2d deviation_mm;  ///< of the mark that it sees, from where it is expected
  Eigen::Matrix2d cov_mm2;
  std::optional<Eigen::Vector2d> blind;  ///< slots: the unit vector along which it sees nothing
  CameraJacobian by_camera = CameraJacobian::Zero();  ///< d deviation / d camera parameters
};

/// The joint result of four views of a target.
struct ViewMean {
  Eigen::Vector2d deviation_mm;  ///< of the target's middle
  Eigen::Matrix2d cov_mm2;
  CameraJacobian by_camera = CameraJacobian::Zero();  ///< d deviation / d camera parameters
  double rotation_rad = 0;  ///< by which the marks are turned about the middle
  /// Distance of each mark from its place by the others, and its sigma in that direction.
  std::vector<double> residual_mm;
  std::vector<double> sigma_mm;
};

/// The mean of views around a target.
///
///   deviation_k = t + theta x offset_k + e_k
///
/// by least squares with equal weights. For views that see both coordinates and lie evenly around
/// the middle t is their plain mean, as the manual has it; views of slots count for the coordinate
/// they see. The target may be turned as its panel is: theta takes that out of the residuals. The
/// covariance is propagated, and enlarged where the residuals are larger than it allows (marks are
/// never exactly where the drawing has them).
///
/// Out    empty if the views leave a coordinate open
/// See    tests/machine/look/view_mean_test.cc
std::optional<ViewMean> mean_of_views(std::span<const ViewDeviation> views);

/// The scatter of repeated inspections: one standard deviation in each axis.
///
/// Precondition: 2 or more.
Displacement<frame::Actual> scatter_of(std::span<const PositionEstimate<frame::Actual>> places);

/// The term to add to the covariance of the mean of inspections because they scatter more than
/// their own covariances allow: zero while that may be chance (chi_square_limit).
///
///   chi2 = sum (p_i - mean)^T C^-1 (p_i - mean),   C the mean covariance of one inspection
///   added = (chi2 / (d (n - 1)) - 1) C / n
///
/// In     places: 2 or more; n_coordinates d: 2, or 1 for slots
/// See    tests/machine/look/view_mean_test.cc
Eigen::Matrix2d excess_scatter(std::span<const PositionEstimate<frame::Actual>> places,
                               int n_coordinates);

}  // namespace panelcal::internal
