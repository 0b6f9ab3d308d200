// SPDX-License-Identifier: Apache-2.0
#include "panelcal/surface/surface_choice.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace panelcal {
namespace {

/// Squares; empty where nothing is foretold.
using Misses = std::vector<std::optional<double>>;

/// What is missed, in units of what each probe is said to scatter.
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

/// Whether `other` misses more than `best` beyond one standard error of the mean difference.
bool is_clearly_worse(const Misses& other, const Misses& best) {
  double worst = 0;
  for (const Misses* all : {&other, &best}) {
    for (const std::optional<double>& miss : *all) worst = std::max(worst, miss.value_or(0));
  }
  double n = 0, sum = 0, squares = 0;
  for (std::size_t i = 0; i < best.size(); ++i) {
    if (!other[i] && !best[i]) continue;
    // What a model does not foretell it cannot have missed little.
    const double difference = !best[i] ? -worst : !other[i] ? worst : *other[i] - *best[i];
    n += 1;
    sum += difference;
    squares += difference * difference;
  }
  if (n == 0) return false;
  const double mean = sum / n;
  return mean > std::sqrt(std::max(0.0, squares / n - mean * mean) / n);
}

std::string comparison(const SurfaceFit& plane, const SurfaceFit& plate, const SurfaceFit& bent) {
  // A model that has as many coefficients as there are probes passes through all of them.
  if (!plane.left_out_rms() || !plate.left_out_rms() || !bent.left_out_rms()) {
    return "the other probes foretell none that is left out, so that nothing checks them";
  }
  return fmt::format(
      "probes left out are missed by {:.2f} sigma of a probe by a plane, {:.2f} by a "
      "thin plate, {:.2f} by a Gaussian process",
      *plane.left_out_rms(),
      *plate.left_out_rms(),
      *bent.left_out_rms());
}

}  // namespace

Expected<ChosenSurface> choose_surface(std::span<const ProbePoint> points,
                                       const OutlierOptions& options) {
  PANELCAL_TRY(SoundSurface bent,
               fit_without_outliers(points, SurfaceModel::GaussianProcess, options));
  std::vector<ProbePoint> kept;
  for (const std::size_t i : bent.kept) kept.push_back(points[i]);
  PANELCAL_TRY(SurfaceFit plane, fit_surface(kept, SurfaceModel::Plane));
  PANELCAL_TRY(SurfaceFit plate, fit_surface(kept, SurfaceModel::ThinPlate));
  std::string reason = comparison(plane, plate, bent.fit);
  const Misses best = misses(bent.fit, kept);
  if (!is_clearly_worse(misses(plane, kept), best)) {
    bent.fit = std::move(plane);
    reason += "; the plane is the simplest that is not clearly worse";
  } else if (!is_clearly_worse(misses(plate, kept), best)) {
    bent.fit = std::move(plate);
    reason += "; the thin plate is not clearly worse";
  } else {
    reason += ", which is the best";
  }
  return ChosenSurface{std::move(bent), std::move(reason)};
}

}  // namespace panelcal
