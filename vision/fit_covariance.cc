// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/fit_covariance.h"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <opencv2/core.hpp>

#include "panelcal/vision/spectrum.h"

namespace panelcal::internal {
namespace {

/// What each pixel contributes to the centre, times a part's share in it.
struct Influence {
  cv::Mat x;
  cv::Mat y;

  Influence(int width, int height)
      : x(cv::Mat::zeros(height, width, CV_32F)), y(cv::Mat::zeros(height, width, CV_32F)) {}
};

/// Rows x and y of the inverse of the information matrix.
Eigen::Matrix<double, 2, kMaxRimParameters> center_rows(const RimProblem& problem,
                                                        const RimSolution& solution) {
  const int n = problem.model.n_parameters();
  const Eigen::MatrixXd h = solution.information.topLeftCorner(n, n);
  const Eigen::MatrixXd units = Eigen::MatrixXd::Identity(n, 2);
  const Eigen::MatrixXd columns = h.ldlt().solve(units);
  Eigen::Matrix<double, 2, kMaxRimParameters> rows;
  rows.setZero();
  rows.leftCols(n) = columns.transpose();
  return rows;
}

struct Influences {
  Influence outside;
  Influence inside;
  Eigen::Matrix2d white = Eigen::Matrix2d::Zero();  ///< covariance from the white noise
};

Influences influences_of(const RimProblem& problem,
                         const RimSolution& solution,
                         const ResidualCorrelation& correlation) {
  const FitWindow& window = problem.window;
  const auto rows = center_rows(problem, solution);
  Influences result{{window.width, window.height}, {window.width, window.height}, {}};
  result.white.setZero();
  for (const WindowPixel& pixel : window.pixels) {
    if (!pixel.in_fit || pixel.is_excluded) continue;
    RimVector gradient = RimVector::Zero();
    const auto value = problem.model.evaluate(pixel, solution.parameters, &gradient);
    if (is_clipped(pixel.value, value.level, problem.full_scale)) continue;
    if (value.zone != RimModel::Zone::Rim) {
      gradient.setZero();
      gradient.segment<3>(kPlane) = value.plane;
      gradient.segment<3>(kContrast) = value.share * value.plane;
    }
    const Eigen::Vector2d a = pixel.weight * (rows * gradient);
    const double inside = std::clamp(value.share, 0.0, 1.0);
    const double white =
        inside * correlation.inside.white + (1 - inside) * correlation.outside.white;
    result.white += white * a * a.transpose();
    const cv::Point at(pixel.x - window.x0, pixel.y - window.y0);
    result.inside.x.at<float>(at) = static_cast<float>(inside * a.x());
    result.inside.y.at<float>(at) = static_cast<float>(inside * a.y());
    result.outside.x.at<float>(at) = static_cast<float>((1 - inside) * a.x());
    result.outside.y.at<float>(at) = static_cast<float>((1 - inside) * a.y());
  }
  return result;
}

Eigen::Matrix2d textured_covariance(const Influence& influence, const Autocovariance& rho) {
  constexpr int kMaxLag = Autocovariance::kMaxLag;
  const cv::Size padded = padded_size(influence.x, kMaxLag);
  const cv::Mat x = spectrum_of(influence.x, padded);
  const cv::Mat y = spectrum_of(influence.y, padded);
  const cv::Mat xx = correlation_of(x, x);
  const cv::Mat xy = correlation_of(x, y);
  const cv::Mat yy = correlation_of(y, y);
  Eigen::Matrix2d cov = Eigen::Matrix2d::Zero();
  for (int dy = -kMaxLag; dy <= kMaxLag; ++dy) {
    for (int dx = -kMaxLag; dx <= kMaxLag; ++dx) {
      const double r = rho.at(dx, dy);
      if (r == 0) continue;
      cov(0, 0) += r * at_lag(xx, dx, dy);
      cov(0, 1) += r * at_lag(xy, dx, dy);
      cov(1, 1) += r * at_lag(yy, dx, dy);
    }
  }
  cov(1, 0) = cov(0, 1);
  return cov;
}

/// Estimated from few lags it may be no covariance: then it is made one by its larger variance.
Eigen::Matrix2d made_positive(const Eigen::Matrix2d& cov) {
  if (cov(0, 0) > 0 && cov(1, 1) > 0 && cov.determinant() > 0) return cov;
  return std::max({0.0, cov(0, 0), cov(1, 1)}) * Eigen::Matrix2d::Identity();
}

}  // namespace

Eigen::Matrix2d center_covariance(const RimProblem& problem,
                                  const RimSolution& solution,
                                  const ResidualCorrelation& correlation) {
  const Influences influences = influences_of(problem, solution, correlation);
  Eigen::Matrix2d cov = influences.white;
  if (correlation.outside.is_textured) {
    cov += made_positive(textured_covariance(influences.outside, correlation.outside));
  }
  if (correlation.inside.is_textured) {
    cov += made_positive(textured_covariance(influences.inside, correlation.inside));
  }
  return correlation.rim_excess * cov;
}

}  // namespace panelcal::internal
