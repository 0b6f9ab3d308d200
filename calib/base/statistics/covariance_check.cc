// SPDX-License-Identifier: Apache-2.0
#include "calib/base/statistics/covariance_check.h"

#include <cmath>

#include "calib/base/statistics/linear_algebra.h"

namespace panelcal::internal {
namespace {

/// Rounding that a covariance may have suffered on its way through other programs.
constexpr double kRounding = 1e-9;

bool is_symmetric(const Eigen::MatrixXd& cov) {
  for (Eigen::Index i = 0; i < cov.rows(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const double size = std::sqrt(std::abs(cov(i, i))) * std::sqrt(std::abs(cov(j, j)));
      if (!(std::abs(cov(i, j) - cov(j, i)) <= kRounding * size)) return false;
    }
  }
  return true;
}

bool is_positive_semidefinite(const Eigen::MatrixXd& cov) {
  const Eigen::Index n = cov.rows();
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(cov(i, i) >= 0)) return false;
    for (Eigen::Index j = 0; j < i; ++j) {
      const double size = std::sqrt(cov(i, i)) * std::sqrt(cov(j, j));
      if (size == 0 && cov(i, j) != 0) return false;
      correlation(i, j) = correlation(j, i) = size == 0 ? 0 : cov(i, j) / size;
    }
  }
  if (!correlation.allFinite()) return false;
  if (n == 0) return true;
  return internal::eigenvalues(correlation).values.minCoeff() >= -kRounding;
}

}  // namespace

std::optional<CovarianceFlaw> covariance_flaw(const Eigen::MatrixXd& cov) {
  if (!cov.allFinite() || !is_symmetric(cov)) {
    return CovarianceFlaw{"the covariance is not symmetric", "a symmetric matrix"};
  }
  if (!is_positive_semidefinite(cov)) {
    return CovarianceFlaw{"the covariance is not positive semidefinite",
                          "variances of at least 0 and correlations that fit together"};
  }
  return std::nullopt;
}

bool is_measured_covariance(const Eigen::Matrix2d& cov_mm2) {
  const auto is_variance = [](double variance_mm2) {
    return variance_mm2 >= kLeastSigma_mm * kLeastSigma_mm &&
           variance_mm2 <= kMostSigma_mm * kMostSigma_mm;
  };
  return is_variance(cov_mm2(0, 0)) && is_variance(cov_mm2(1, 1)) && is_symmetric(cov_mm2) &&
         // By correlation, so that no product of tiny numbers underflows.
         std::abs(cov_mm2(0, 1) / std::sqrt(cov_mm2(0, 0)) / std::sqrt(cov_mm2(1, 1))) < 1;
}

}  // namespace panelcal::internal
