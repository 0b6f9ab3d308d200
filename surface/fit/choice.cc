// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
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

bool foretells_better(const SurfaceFit& one, const SurfaceFit& other) {
  constexpr double kNothing = std::numeric_limits<double>::infinity();
  return one.left_out_rms().value_or(kNothing) < other.left_out_rms().value_or(kNothing);
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
  const std::size_t n_smooth = fits.size();
  if (sound.outliers.empty()) {
    for (const SurfaceModel model : {SurfaceModel::Bilinear, SurfaceModel::MonotoneBicubic}) {
      // Most probes make no grid.
      if (auto fit = fit_surface(kept, model)) fits.push_back(*std::move(fit));
    }
  }
  const std::span<const SurfaceFit> smooth(fits.data(), n_smooth);
  std::string reason = comparison(fits);
  const Misses best = misses(sound.fit, kept);
  const auto is_good = [&](const SurfaceFit& fit) {
    return fit.noise_factor() <= options.most_noise && !is_clearly_worse(misses(fit, kept), best);
  };
  std::size_t chosen = 2;
  if (is_good(smooth[0])) {
    chosen = 0;
    reason += "; the plane is the simplest that is not clearly worse";
  } else if (is_good(smooth[1]) && foretells_better(smooth[1], smooth[2])) {
    chosen = 1;
    reason += "; the thin plate misses least";
  } else {
    reason += fmt::format("; the {} is the best of the smooth ones", name_of(sound.fit.model()));
  }
  for (std::size_t k = n_smooth; k < fits.size(); ++k) {
    if (!is_clearly_worse(misses(fits[chosen], kept), misses(fits[k], kept))) continue;
    chosen = k;
    reason += fmt::format("; but {} misses clearly less", name_of(fits[k].model()));
  }
  sound.fit = fits[chosen];
  return ChosenSurface{std::move(sound), std::move(reason)};
}

}  // namespace panelcal
