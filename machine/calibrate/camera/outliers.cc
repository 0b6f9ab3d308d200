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
#include "calib/base/statistics/median.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Honest noise of two coordinates is so far off once in 270000.
constexpr double kCameraOutlierSigmas = 5;
/// Part of the calibrations without outliers that lose a look.
constexpr double kSoundLookLost = 1e-3;
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

/// log (n choose k).
double log_choices(std::size_t n, std::size_t k) {
  const auto log_factorial = [](std::size_t m) { return std::lgamma(static_cast<double>(m) + 1); };
  return log_factorial(n) - log_factorial(k) - log_factorial(n - k);
}

/// True if the looks that are not kept scatter about the fit of those that are by more than chance
/// allows the worst of all looks: F test with Bonferroni's correction.
bool is_disproved(const CameraData& data,
                  std::vector<CameraObservation> kept,
                  CameraFitOptions options,
                  CameraForm form) {
  options.form = form;
  options.held_out_every = 0;
  const std::size_t n_kept = kept.size();
  CameraData others = data;
  others.seen = std::move(kept);
  const Expected<CameraFit> without = fit_camera(others, options);
  if (!without || without->degrees_of_freedom < 1) return false;
  const Expected<CameraFit> with = fit_camera(data, options);
  if (!with) return true;  // No camera shows them all, and one shows the others.
  const int n_more = with->degrees_of_freedom - without->degrees_of_freedom;
  if (n_more < 1) return false;
  // The stated noise is a lower bound.
  const double variance = std::max(1.0, without->chi_square / without->degrees_of_freedom);
  const double ratio = (with->chi_square - without->chi_square) / (n_more * variance);
  const double chance = variance_ratio_exceedance(ratio, n_more, without->degrees_of_freedom);
  const std::size_t n_suspects = data.seen.size() - n_kept;
  return std::log(chance) + log_choices(data.seen.size(), n_suspects) < std::log(kSoundLookLost);
}

std::string sight_words(const MarkSights& sights, const CameraObservation& seen) {
  const std::string& view = sights.names[seen.i_view];
  return sights.data.dots.size() == 1 ? view : fmt::format("{}, dot {}", view, seen.i_dot);
}

}  // namespace

Expected<int> leave_out_outliers(const CameraFitOptions& options, MarkSights& sights) {
  CameraFitOptions robust = options;
  robust.huber_sigmas = kHuberSigmas;
  robust.held_out_every = 0;
  int n_left_out = 0;
  for (int round = 0; round < kCameraOutlierRounds; ++round) {
    // By a stiffer form than the one that is fitted, what a lens bends would be an outlier.
    PANELCAL_TRY(const CameraFit fit, choose_camera(sights.data, robust));
    if (fit.degrees_of_freedom < kFewestCameraFreedoms) break;
    const std::vector<double> off = sigmas_off(sights.data, fit);
    const double sigma = scatter(off, fit.degrees_of_freedom);
    std::vector<CameraObservation> kept;
    std::vector<MissedPicture> suspects;
    for (std::size_t i = 0; i < off.size(); ++i) {
      const CameraObservation& seen = sights.data.seen[i];
      if (off[i] <= kCameraOutlierSigmas * sigma) {
        kept.push_back(seen);
        continue;
      }
      suspects.push_back({sight_words(sights, seen),
                          fmt::format("it does not fit the others: {:.3f} px off, {:.1f} times "
                                      "what they scatter",
                                      fit.residuals[i].in_px().norm(),
                                      off[i] / sigma)});
    }
    if (suspects.empty() || !is_disproved(sights.data, kept, options, fit.form)) break;
    n_left_out += static_cast<int>(suspects.size());
    sights.missed.insert(sights.missed.end(), suspects.begin(), suspects.end());
    sights.data.seen = std::move(kept);
  }
  return n_left_out;
}

}  // namespace panelcal::internal
