// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace panelcal {
namespace {

/// Squares; empty where nothing is predicted.
using Misses = std::vector<std::optional<double>>;

/// Prediction errors in units of each probe's stated sigma.
Misses misses(const SurfaceFit& fit, std::span<const ProbePoint> points) {
  Misses out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::optional<Length> deviation = fit.left_out()[i].deviation;
    out.emplace_back();
    if (!deviation) continue;
    const double by_sigma = *deviation / points[i].measured.sigma;
    out.back() = by_sigma * by_sigma;
  }
  return out;
}

/// True if `other` misses more than `best` beyond one standard error of the mean difference.
bool is_clearly_worse(const Misses& other, const Misses& best) {
  double worst = 0;
  for (const Misses* all : {&other, &best}) {
    for (const std::optional<double>& miss : *all) worst = std::max(worst, miss.value_or(0));
  }
  double n = 0, sum = 0, squares = 0;
  for (std::size_t i = 0; i < best.size(); ++i) {
    if (!other[i] && !best[i]) continue;
    // A model that does not predict a probe cannot have missed it by little.
    const double difference = !best[i] ? -worst : !other[i] ? worst : *other[i] - *best[i];
    n += 1;
    sum += difference;
    squares += difference * difference;
  }
  if (n == 0) return false;
  const double mean = sum / n;
  return mean > std::sqrt(std::max(0.0, squares / n - mean * mean) / n);
}

/// True if all that a plane misses may be scatter: of stated scatter by chance, of an assumed
/// one if it is not much more.
bool is_scatter_enough(const SurfaceFit& plane) {
  constexpr double kMostAssumed = 2;
  return plane.shape().unresolved == mm(0) && plane.noise_factor() <= kMostAssumed;
}

std::string comparison(std::span<const SurfaceFit> fits) {
  // A model that has as many coefficients as there are probes passes through all of them.
  std::string out;
  for (const SurfaceFit& fit : fits) {
    const std::optional<double> rms = fit.left_out_rms();
    if (!rms)
      return "no probe that is left out is predicted by the others, so that no model is checked";
    const char* article = is_of_grid(fit.model()) ? "" : "a ";
    out += out.empty()
               ? fmt::format("probes left out are missed by {:.2f} sigma of a probe by {}{}",
                             *rms,
                             article,
                             name_of(fit.model()))
               : fmt::format(", {:.2f} by {}{}", *rms, article, name_of(fit.model()));
  }
  return out;
}

/// Of more probes than are solved for.
Expected<ChosenSurface> choose_grid(std::span<const ProbePoint> points,
                                    const OutlierOptions& options) {
  // Without a grid these are too many probes.
  if (!fit_surface(points, SurfaceModel::Bilinear)) {
    PANELCAL_CHECK(check_probes(points, SurfaceModel::GaussianProcess));
  }
  PANELCAL_TRY(SoundSurface sound, fit_without_outliers(points, SurfaceModel::Bilinear, options));
  PANELCAL_TRY(SurfaceFit bicubic, fit_surface(points, SurfaceModel::MonotoneBicubic));
  const std::array fits = {sound.fit, std::move(bicubic)};
  std::string reason = comparison(fits);
  if (is_clearly_worse(misses(fits[0], points), misses(fits[1], points))) {
    sound.fit = fits[1];
    reason += "; monotone bicubic misses clearly less";
  } else {
    reason += "; bilinear is not clearly worse";
  }
  reason += fmt::format("; {} probes are too many for other models", points.size());
  return ChosenSurface{std::move(sound), std::move(reason)};
}

/// True if a plane is simplest and not clearly worse than a process of the same probes.
bool prefers_plane(const SurfaceFit& plane,
                   const SurfaceFit& process,
                   std::span<const ProbePoint> kept,
                   const OutlierOptions& options) {
  // A bend as small as the scatter escapes so few probes: the process says how much it may be.
  // Fewer tell nothing of it, whatever the model.
  constexpr std::size_t kTellNothing = 5, kTellPlanes = 13;
  // A bend that few probes may show is in the sigma of the process alone.
  if (!process.possible_bends().empty() || process.shape().unresolved > mm(0)) return false;
  const bool tells_something = kept.size() > kTellNothing && process.has_seen_bending();
  if (tells_something && kept.size() < kTellPlanes) return false;
  const Misses of_process = misses(process, kept);
  // A bend that hangs on single probes is no reason against a plane.
  const bool hangs = std::ranges::any_of(of_process, [](const auto& miss) { return !miss; });
  return plane.noise_factor() <= options.most_noise && (hangs || is_scatter_enough(plane)) &&
         !is_clearly_worse(misses(plane, kept), of_process);
}

}  // namespace

Expected<ChosenSurface> choose_surface(std::span<const ProbePoint> points,
                                       const OutlierOptions& options) {
  if (points.size() > kMostBentProbes) return choose_grid(points, options);
  PANELCAL_TRY(SoundSurface sound,
               fit_without_outliers(points, SurfaceModel::GaussianProcess, options));
  std::vector<ProbePoint> kept;
  for (const std::size_t i : sound.kept) kept.push_back(points[i]);
  std::vector<SurfaceFit> fits;
  for (const SurfaceModel model : {SurfaceModel::Plane, SurfaceModel::ThinPlate}) {
    PANELCAL_TRY(SurfaceFit fit, fit_surface(kept, model));
    fits.push_back(std::move(fit));
  }
  fits.push_back(sound.fit);
  if (sound.outliers.empty()) {
    for (const SurfaceModel model : {SurfaceModel::Bilinear, SurfaceModel::MonotoneBicubic}) {
      // Most probes make no grid.
      if (auto fit = fit_surface(kept, model)) fits.push_back(*std::move(fit));
    }
  }
  std::string reason = comparison(fits);
  if (prefers_plane(fits.front(), sound.fit, kept, options)) {
    sound.fit = fits.front();
    reason += "; the plane is the simplest that is not clearly worse";
  } else {
    reason +=
        "; the Gaussian process alone averages kernels, so that its sigma has their difference";
  }
  if (!sound.doubt.empty()) reason += "; " + sound.doubt;
  return ChosenSurface{std::move(sound), std::move(reason)};
}

}  // namespace panelcal
