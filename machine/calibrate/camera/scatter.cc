// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/camera/scatter.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "calib/base/statistics/linear_algebra.h"

namespace panelcal::internal {
namespace {

constexpr int kScatterRounds = 10;
constexpr double kScatterSettled = 1e-3;  // relative; the solver stops as early
constexpr int kScatterBisections = 60;

/// The value of which half of the weight, at most, is below.
double weighted_median(std::vector<std::pair<double, double>> values_and_weights) {
  std::ranges::sort(values_and_weights);
  double all = 0;
  for (const auto& [value, weight] : values_and_weights) all += weight;
  double below = 0;
  for (const auto& [value, weight] : values_and_weights) {
    below += weight;
    if (below > 0.5 * all) return value;
  }
  return 0;
}

/// The variance at which a statistic of residuals, which falls with it at least as fast as 1 over
/// the variance does, is what it should be; 0 if it is less without.
template <class Statistic>
double scatter_px2(const Statistic& at_variance, double most_px2) {
  if (at_variance(0) <= 0) return 0;
  double low = 0;
  double high = most_px2;
  for (int i = 0; i < kScatterBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (at_variance(middle) > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double sum_of_squares_px2(const CameraFit& fit) {
  double sum_px2 = 0;
  for (const auto& residual : fit.residuals) sum_px2 += residual.in_px().squaredNorm();
  return sum_px2;
}

double term_of(const CameraData& data, const CameraFit& fit, std::size_t i, double variance_px2) {
  return squared_distance(fit.residuals[i].in_px(),
                          data.seen[i].seen.cov + variance_px2 * Eigen::Matrix2d::Identity());
}

/// Fits in turns with the variance of the fit before.
template <class VarianceOf>
Expected<ScatteredFit> fit_in_turns(const CameraData& data,
                                    const CameraFitter& fitter,
                                    const VarianceOf& variance_of) {
  PANELCAL_TRY(CameraFit stated, fitter(data));
  ScatteredFit scattered{0, data, stated, std::move(stated)};
  for (int round = 0; round < kScatterRounds; ++round) {
    const double variance_px2 = variance_of(scattered.fit);
    if (std::abs(variance_px2 - scattered.variance_px2) <= kScatterSettled * variance_px2) break;
    scattered.variance_px2 = variance_px2;
    scattered.data = with_scatter(data, variance_px2);
    PANELCAL_TRY(scattered.fit, fitter(scattered.data));
  }
  return scattered;
}

}  // namespace

CameraData with_scatter(CameraData data, double variance_px2) {
  for (CameraObservation& seen : data.seen) {
    seen.seen.cov += variance_px2 * Eigen::Matrix2d::Identity();
  }
  return data;
}

Expected<ScatteredFit> fit_scattered(const CameraData& data,
                                     const CameraFitter& fitter,
                                     const std::function<double(int)>& wanted) {
  return fit_in_turns(data, fitter, [&](const CameraFit& fit) {
    const double aim = wanted(fit.degrees_of_freedom);
    if (!(aim > 0)) return 0.0;
    const auto too_much = [&](double variance_px2) {
      double chi_square = 0;
      for (std::size_t i = 0; i < data.seen.size(); ++i) {
        chi_square += term_of(data, fit, i, variance_px2);
      }
      return chi_square - aim;
    };
    return scatter_px2(too_much, sum_of_squares_px2(fit) / aim);
  });
}

Expected<ScatteredFit> fit_scattered_robustly(const CameraData& data, const CameraFitter& fitter) {
  return fit_in_turns(data, fitter, [&](const CameraFit& fit) {
    // Residuals are shorter than errors by nu / (2 n).
    const double aim = 2 * std::numbers::ln2 * fit.degrees_of_freedom /
                       (2 * static_cast<double>(data.seen.size()));
    if (!(aim > 0)) return 0.0;
    const auto too_much = [&](double variance_px2) {
      std::vector<std::pair<double, double>> terms;
      for (std::size_t i = 0; i < data.seen.size(); ++i) {
        const double own_px2 = 0.5 * data.seen[i].seen.cov.trace() + variance_px2;
        terms.emplace_back(term_of(data, fit, i, variance_px2), 1 / (own_px2 * own_px2));
      }
      return weighted_median(std::move(terms)) - aim;
    };
    return scatter_px2(too_much, sum_of_squares_px2(fit) / aim);
  });
}

}  // namespace panelcal::internal
