// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/residual_correlation.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <opencv2/core.hpp>

#include "panelcal/vision/spectrum.h"

namespace panelcal::internal {
namespace {

constexpr int kTestLag = 4;
constexpr double kRounding = 0.2887;  // sigma of rounding to whole levels
constexpr int kFewPairs = 30;

/// One part of the window as pictures.
struct Part {
  cv::Mat residual;
  cv::Mat mask;

  Part(int width, int height)
      : residual(cv::Mat::zeros(height, width, CV_32F)),
        mask(cv::Mat::zeros(height, width, CV_32F)) {}
};

/// Sum over pairs at one lag, in the plain way.
double sum_at_lag(const cv::Mat& a, int dx, int dy) {
  const int width = a.cols - std::abs(dx);
  const int height = a.rows - dy;
  if (width <= 0 || height <= 0) return 0;
  const cv::Mat first = a(cv::Rect(dx < 0 ? -dx : 0, 0, width, height));
  const cv::Mat second = a(cv::Rect(dx < 0 ? 0 : dx, dy, width, height));
  return first.dot(second);
}

/// Portmanteau test on short lags, in two dimensions.
bool is_textured(const Part& part, double variance) {
  double statistic = 0;
  int n_lags = 0;
  for (int dy = 0; dy <= kTestLag; ++dy) {
    for (int dx = dy == 0 ? 1 : -kTestLag; dx <= kTestLag; ++dx) {
      const double n_pairs = sum_at_lag(part.mask, dx, dy);
      if (n_pairs < kFewPairs) continue;
      const double rho = sum_at_lag(part.residual, dx, dy) / variance / n_pairs;
      statistic += n_pairs * rho * rho;
      ++n_lags;
    }
  }
  // Chi square of n_lags degrees of freedom: mean n_lags, variance 2 n_lags.
  return statistic > n_lags + 5 * std::sqrt(2.0 * n_lags) + 5;
}

/// All lags, tapered to the longest so that few pairs count little.
std::vector<float> table_of(const Part& part, double n_pixels) {
  constexpr int kMaxLag = Autocovariance::kMaxLag;
  const cv::Size padded = padded_size(part.mask, kMaxLag);
  const cv::Mat residual = spectrum_of(part.residual, padded);
  const cv::Mat mask = spectrum_of(part.mask, padded);
  const cv::Mat sums = correlation_of(residual, residual);
  const cv::Mat pairs = correlation_of(mask, mask);
  std::vector<float> table;
  table.reserve(static_cast<std::size_t>(2 * kMaxLag + 1) * (2 * kMaxLag + 1));
  for (int dy = -kMaxLag; dy <= kMaxLag; ++dy) {
    for (int dx = -kMaxLag; dx <= kMaxLag; ++dx) {
      const double n = at_lag(pairs, dx, dy);
      const double lag = std::hypot(dx, dy) / kMaxLag;
      const bool counts = lag < 1 && n > 0.02 * n_pixels + kFewPairs;
      const double taper = 0.5 * (1 + std::cos(CV_PI * lag));
      table.push_back(counts ? static_cast<float>(taper * at_lag(sums, dx, dy) / n) : 0.0F);
    }
  }
  return table;
}

/// The white part: what lag 0 has above a smooth texture's autocovariance, which is continued from
/// lags 1 and 2 as a parabola.
double white_variance(const Part& part, double variance) {
  const auto mean_at = [&](int lag) {
    const double sums = sum_at_lag(part.residual, lag, 0) + sum_at_lag(part.residual, 0, lag);
    const double pairs = sum_at_lag(part.mask, lag, 0) + sum_at_lag(part.mask, 0, lag);
    return sums / std::max(1.0, pairs);
  };
  const double texture = (4 * mean_at(1) - mean_at(2)) / 3;
  return std::clamp(variance - texture, kRounding * kRounding, variance);
}

Autocovariance autocovariance_of(const Part& part, double used_parameters) {
  Autocovariance result;
  const double n_pixels = cv::countNonZero(part.mask);
  const double sum = part.residual.dot(part.residual);
  result.variance =
      std::max(kRounding * kRounding, sum / std::max(1.0, n_pixels - used_parameters));
  result.is_textured = is_textured(part, result.variance);
  result.white = result.variance;
  if (!result.is_textured) return result;
  result.white = white_variance(part, result.variance);
  result.table = table_of(part, n_pixels);
  result.table[result.table.size() / 2] = static_cast<float>(result.variance - result.white);
  return result;
}

}  // namespace

ResidualCorrelation residual_correlation(const RimProblem& problem, const RimSolution& solution) {
  const FitWindow& window = problem.window;
  Part outside(window.width, window.height);
  Part inside(window.width, window.height);
  double rim_chi_square = 0;
  double rim_square = 0;
  int n_rim = 0;
  for (const WindowPixel& pixel : window.pixels) {
    if (!pixel.in_fit || pixel.is_excluded) continue;
    const auto value = problem.model.evaluate(pixel, solution.parameters, nullptr);
    if (is_clipped(pixel.value, value.level, problem.full_scale)) continue;
    const double residual = pixel.value - value.level;
    Part& part = value.share > 0.5 ? inside : outside;
    const cv::Point at(pixel.x - window.x0, pixel.y - window.y0);
    part.residual.at<float>(at) = static_cast<float>(residual);
    part.mask.at<float>(at) = 1;
    if (std::abs(value.distance_px) < 2.5 * solution.parameters[kSigma]) {
      rim_chi_square += residual * residual * pixel.weight;
      rim_square += residual * residual;
      ++n_rim;
    }
  }
  const double used = 0.5 * problem.model.n_parameters();
  ResidualCorrelation result{autocovariance_of(outside, used), autocovariance_of(inside, used)};
  if (n_rim > 0) {
    result.rim_noise = std::sqrt(rim_square / n_rim);
    const double ratio = rim_chi_square / n_rim;
    // Three standard deviations of a chi square over its degrees of freedom.
    if (ratio > 1 + 3 * std::sqrt(2.0 / n_rim)) result.rim_excess = ratio;
  }
  return result;
}

}  // namespace panelcal::internal
