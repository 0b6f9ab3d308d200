// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/camera/outliers.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/statistics/distributions.h"
#include "calib/base/statistics/linear_algebra.h"
#include "machine/calibrate/camera/scatter.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Honest noise of two coordinates is so far off once in 270000.
constexpr double kCameraOutlierSigmas = 5;
/// One of several suspects has to be so far off with as much scatter as the others allow.
constexpr double kSurelyOffSigmas = 3;
/// Part of the calibrations without outliers that lose a look.
constexpr double kSoundLookLost = 1e-3;
/// Part of them whose scatter is less than is allowed for, and whose scatter is more.
constexpr double kScatterMissed = 1e-3;
/// Factor of a variance with which an observation has no weight.
constexpr double kUnheeded = 1e8;
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

/// log (n choose k).
double log_choices(std::size_t n, std::size_t k) {
  const auto log_factorial = [](std::size_t m) { return std::lgamma(static_cast<double>(m) + 1); };
  return log_factorial(n) - log_factorial(k) - log_factorial(n - k);
}

/// Part of the stated variances, with `scatter_px2` more, below which no variance can be.
double least_part(const CameraData& data, double scatter_px2) {
  double least = 0;
  for (const CameraObservation& seen : data.seen) {
    const double stated_px2 = 0.5 * seen.seen.cov.trace();
    least = std::max(least, stated_px2 / (stated_px2 + scatter_px2));
  }
  return least;
}

/// By what variance the others scatter beyond what is stated, if the looks that are not among them
/// scatter about their fit by more than chance allows the worst of all looks: F test with
/// Bonferroni's correction.
///
/// In     chance: that the others' chi square is larger than it is taken to be here, which says how
///        much they scatter
std::optional<double> scatter_disproving(const CameraData& data,
                                         const CameraData& others,
                                         const CameraFitter& fitter,
                                         double chance) {
  const auto without = fit_scattered(
      others, fitter, [&](int nu) { return nu < 1 ? 0 : chi_square_of_exceedance(chance, nu); });
  if (!without || without->fit.degrees_of_freedom < 1) return {};
  const Expected<CameraFit> with = fitter(with_scatter(data, without->variance_px2));
  if (!with) return without->variance_px2;  // No camera shows them all, and one shows the others.
  const int nu = without->fit.degrees_of_freedom;
  const int n_more = with->degrees_of_freedom - nu;
  if (n_more < 1) return {};
  const double variance =
      std::max(least_part(data, without->variance_px2), without->fit.chi_square / nu);
  const double ratio = (with->chi_square - without->fit.chi_square) / (n_more * variance);
  const std::size_t n_suspects = data.seen.size() - others.seen.size();
  const double log_chance = std::log(variance_ratio_exceedance(ratio, n_more, nu)) +
                            log_choices(data.seen.size(), n_suspects);
  if (!(log_chance < std::log(kSoundLookLost))) return {};
  return without->variance_px2;
}

/// Which of the suspects the others disprove, with as little and with as much scatter as they
/// allow: all together by the F test, and each by its distance from their fit. If all views state
/// one sigma the test does not depend on the scatter; but blurred views do not tell how far a stage
/// moves sharp ones.
std::vector<char> disproved(const CameraData& data,
                            const std::vector<char>& is_suspect,
                            CameraFitOptions options,
                            CameraForm form) {
  std::vector<char> out(data.seen.size(), 0);
  options.form = form;
  options.held_out_every = 0;
  const auto fitter = [&](const CameraData& of) { return fit_camera(of, options); };
  CameraData others = data;
  others.seen.clear();
  for (std::size_t i = 0; i < data.seen.size(); ++i) {
    if (is_suspect[i] == 0) others.seen.push_back(data.seen[i]);
  }
  if (!scatter_disproving(data, others, fitter, kScatterMissed)) return out;
  const auto most_px2 = scatter_disproving(data, others, fitter, 1 - kScatterMissed);
  if (!most_px2) return out;
  if (std::ranges::count(is_suspect, 1) == 1) return is_suspect;
  const CameraData scattered = with_scatter(data, *most_px2);
  CameraData unheeded = scattered;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (is_suspect[i] != 0) unheeded.seen[i].seen.cov *= kUnheeded;
  }
  const Expected<CameraFit> fit = fitter(unheeded);
  if (!fit) return is_suspect;
  const std::vector<double> off = sigmas_off(scattered, *fit);
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = is_suspect[i] != 0 && off[i] > kSurelyOffSigmas ? 1 : 0;
  }
  return out;
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
    PANELCAL_TRY(const ScatteredFit scattered,
                 fit_scattered_robustly(sights.data, [&](const CameraData& data) {
                   return choose_camera(data, robust);
                 }));
    const CameraFit& fit = scattered.fit;
    if (fit.degrees_of_freedom < kFewestCameraFreedoms) break;
    const std::vector<double> off = sigmas_off(scattered.data, fit);
    std::vector<char> is_suspect;
    for (const double sigmas : off) is_suspect.push_back(sigmas > kCameraOutlierSigmas ? 1 : 0);
    if (std::ranges::count(is_suspect, 1) == 0) break;
    const std::vector<char> leaves = disproved(sights.data, is_suspect, options, fit.form);
    if (std::ranges::count(leaves, 1) == 0) break;
    std::vector<CameraObservation> kept;
    for (std::size_t i = 0; i < off.size(); ++i) {
      const CameraObservation& seen = sights.data.seen[i];
      if (leaves[i] == 0) {
        kept.push_back(seen);
        continue;
      }
      ++n_left_out;
      sights.missed.push_back({sight_words(sights, seen),
                               fmt::format("it does not fit the others: {:.3f} px off, {:.1f} "
                                           "times what they scatter",
                                           fit.residuals[i].in_px().norm(),
                                           off[i])});
    }
    sights.data.seen = std::move(kept);
  }
  return n_left_out;
}

}  // namespace panelcal::internal
