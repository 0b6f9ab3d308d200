// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include <Eigen/Core>

namespace panelcal::internal {

/// The flaw that keeps a matrix of a file from being a covariance.
struct CovarianceFlaw {
  std::string_view what;
  std::string_view expected;
};

/// Symmetry and definiteness are judged on correlations, since variances of one calibration differ
/// by thirty orders of magnitude, and leave room for rounding in other programs. A parameter that
/// is held has the variance 0.
///
/// In     cov: square
/// Out    empty if it is a covariance
std::optional<CovarianceFlaw> covariance_flaw(const Eigen::MatrixXd& cov);

}  // namespace panelcal::internal
