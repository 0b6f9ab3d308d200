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

/// A metre: a place that is known no better was not measured.
inline constexpr double kMostSigma_mm = 1000;
/// Less than the radius of an atom by far.
inline constexpr double kLeastSigma_mm = 1e-9;

/// Symmetric and positive definite, mm^2, with sigmas from kLeastSigma_mm to kMostSigma_mm: what a
/// measured place may have. Beyond, searches would be endless or their results infinite.
bool is_measured_covariance(const Eigen::Matrix2d& cov_mm2);

}  // namespace panelcal::internal
