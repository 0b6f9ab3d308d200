// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/camera/outliers.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/statistics/distributions.h"
#include "calib/base/statistics/linear_algebra.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Honest noise of two coordinates is so far off once in 270000.
constexpr double kCameraOutlierSigmas = 5;
/// Degrees of freedom that a median is judged by; with fewer, chance would make outliers.
constexpr int kFewestOutlierFreedoms = 8;
/// Of a calibration without outliers.
constexpr double kSoundLookLost = 1e-3;
/// Another fit shows the view that one bad view hides.
constexpr int kCameraOutlierRounds = 5;

double median_distance_px(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Length of each residual over the sigma of its direction.
std::vector<double> sigmas_off(const CameraData& data, const CameraFit& fit) {
  std::vector<double> out;
  for (std::size_t i = 0; i < data.seen.size(); ++i) {
    const Eigen::Vector2d& residual_px = fit.residuals[i].in_px();
    out.push_back(std::sqrt(internal::squared_distance(residual_px, data.seen[i].seen.cov)));
  }
  return out;
}

/// Factor of stated sigmas that gives the median the value of honest noise.
///
///   median of chi square (2) = 2 ln 2; residuals are shorter than errors by dof / (2 n)
double scatter(const std::vector<double>& off, int degrees_of_freedom) {
  const double honest =
      std::sqrt(2 * std::numbers::ln2 * degrees_of_freedom / (2 * static_cast<double>(off.size())));
  return std::max(1.0, median_distance_px(off) / honest);
}

/// log (n choose k).
double log_ways(std::size_t n, std::size_t k) {
  const auto log_factorial = [](std::size_t m) { return std::lgamma(static_cast<double>(m) + 1); };
  return log_factorial(n) - log_factorial(k) - log_factorial(n - k);
}

/// True if all looks scatter more than those kept, by more than chance would have the worst of
/// them.
bool is_worse_with(const CameraData& data,
                   const std::vector<CameraObservation>& kept,
                   CameraFitOptions options,
                   CameraForm form) {
  options.form = form;
  options.held_out_every = 0;
  CameraData others = data;
  others.seen = kept;
  const Expected<CameraFit> with = fit_camera(data, options);
  const Expected<CameraFit> without = fit_camera(others, options);
  if (!with || !without || without->degrees_of_freedom < 1) return false;
  const int n_more = with->degrees_of_freedom - without->degrees_of_freedom;
  if (n_more < 1) return false;
  // Stated noise is the least there is.
  const double variance = std::max(1.0, without->chi_square / without->degrees_of_freedom);
  const double ratio = (with->chi_square - without->chi_square) / (n_more * variance);
  const double chance = variance_ratio_exceedance(ratio, n_more, without->degrees_of_freedom);
  return std::log(chance) + log_ways(data.seen.size(), data.seen.size() - kept.size()) <
         std::log(kSoundLookLost);
}

std::string sight_words(const MarkSights& sights, const CameraObservation& seen) {
  const std::string& view = sights.names[seen.i_view];
  return sights.data.dots.size() == 1 ? view : fmt::format("{}, dot {}", view, seen.i_dot);
}

}  // namespace

Expected<CameraFit> softest_camera(const CameraData& data, CameraFitOptions options, int fewest) {
  options.held_out_every = 0;
  options.form = kCameraForms.front();
  Expected<CameraFit> softest = fit_camera(data, options);
  for (const CameraForm form : kCameraForms) {
    options.form = form;
    Expected<CameraFit> fit = fit_camera(data, options);
    if (!fit) continue;
    if (softest && fit->degrees_of_freedom < fewest) break;
    // A softer form that fits worse has not found its minimum.
    if (softest && fit->chi_square > softest->chi_square) continue;
    softest = std::move(fit);
  }
  return softest;
}

Expected<int> leave_out_outliers(const CameraFitOptions& options, MarkSights& sights) {
  CameraFitOptions robust = options;
  robust.huber_sigmas = kHuberSigmas;
  int n_left_out = 0;
  for (int round = 0; round < kCameraOutlierRounds; ++round) {
    PANELCAL_TRY(const CameraFit fit, softest_camera(sights.data, robust, kFewestOutlierFreedoms));
    if (fit.degrees_of_freedom < kFewestOutlierFreedoms) break;
    const std::vector<double> off = sigmas_off(sights.data, fit);
    const double sigma = scatter(off, fit.degrees_of_freedom);
    std::vector<CameraObservation> kept;
    std::vector<MissedPicture> missed;
    for (std::size_t i = 0; i < off.size(); ++i) {
      const CameraObservation& seen = sights.data.seen[i];
      if (off[i] <= kCameraOutlierSigmas * sigma) {
        kept.push_back(seen);
        continue;
      }
      missed.push_back({sight_words(sights, seen),
                        fmt::format("it does not fit the others: {:.3f} px off, {:.1f} times "
                                    "what they scatter",
                                    fit.residuals[i].in_px().norm(),
                                    off[i] / sigma)});
    }
    const auto n_now = static_cast<int>(off.size() - kept.size());
    if (n_now == 0 || !is_worse_with(sights.data, kept, options, fit.form)) break;
    n_left_out += n_now;
    sights.missed.insert(sights.missed.end(), missed.begin(), missed.end());
    sights.data.seen = std::move(kept);
  }
  return n_left_out;
}

}  // namespace panelcal::internal
