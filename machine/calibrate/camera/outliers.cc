// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/camera/outliers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/base/statistics/median.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Honest noise of two coordinates is so far off once in 270000.
constexpr double kCameraOutlierSigmas = 5;
/// Another fit shows an outlier that one bad view hides.
constexpr int kCameraOutlierRounds = 5;

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
  return std::max(1.0, median(off) / honest);
}

std::string sight_words(const MarkSights& sights, const CameraObservation& seen) {
  const std::string& view = sights.names[seen.i_view];
  return sights.data.dots.size() == 1 ? view : fmt::format("{}, dot {}", view, seen.i_dot);
}

}  // namespace

Expected<CameraFit> least_scattered_camera(const CameraData& data, CameraFitOptions options) {
  options.held_out_every = 0;
  Expected<CameraFit> best = CameraFit();
  double least = std::numeric_limits<double>::infinity();
  for (const CameraForm form : kCameraForms) {
    options.form = form;
    Expected<CameraFit> fit = fit_camera(data, options);
    const bool is_first = !std::isfinite(least);
    if (!fit) {
      if (is_first) best = std::move(fit);
      continue;
    }
    if (!is_first && fit->degrees_of_freedom < kFewestFreedoms) break;
    // A softer form that fits worse has not found its minimum.
    const double scatter = fit->chi_square / std::max(1, fit->degrees_of_freedom);
    if (!(scatter < least)) continue;
    least = scatter;
    best = std::move(fit);
  }
  return best;
}

Expected<int> leave_out_outliers(const CameraFitOptions& options, MarkSights& sights) {
  CameraFitOptions robust = options;
  robust.huber_sigmas = kHuberSigmas;
  int n_left_out = 0;
  for (int round = 0; round < kCameraOutlierRounds; ++round) {
    PANELCAL_TRY(const CameraFit fit, least_scattered_camera(sights.data, robust));
    if (fit.degrees_of_freedom < kFewestFreedoms) break;
    const std::vector<double> off = sigmas_off(sights.data, fit);
    const double sigma = scatter(off, fit.degrees_of_freedom);
    std::vector<CameraObservation> kept;
    for (std::size_t i = 0; i < off.size(); ++i) {
      const CameraObservation& seen = sights.data.seen[i];
      if (off[i] <= kCameraOutlierSigmas * sigma) {
        kept.push_back(seen);
        continue;
      }
      sights.missed.push_back(
          {sight_words(sights, seen),
           fmt::format("it does not fit the others: {:.3f} px off, {:.1f} times "
                       "what they scatter",
                       fit.residuals[i].in_px().norm(),
                       off[i] / sigma)});
    }
    const auto n_now = static_cast<int>(off.size() - kept.size());
    if (n_now == 0) break;
    n_left_out += n_now;
    sights.data.seen = std::move(kept);
  }
  return n_left_out;
}

}  // namespace panelcal::internal
