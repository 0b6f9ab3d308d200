// SPDX-License-Identifier: Apache-2.0
#include "panelcal/surface/surface_choice.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace panelcal {
namespace {

/// Squares of what is missed, in units of what each probe is said to scatter.
std::vector<double> misses(const SurfaceFit& fit, std::span<const ProbePoint> points) {
  std::vector<double> out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double deviation = fit.left_out()[i].deviation / points[i].measured.sigma;
    out.push_back(deviation * deviation);
  }
  return out;
}

/// Whether `other` misses more than `best` beyond one standard error of the mean difference.
bool is_clearly_worse(const std::vector<double>& other, const std::vector<double>& best) {
  const double n = static_cast<double>(best.size());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < best.size(); ++i) {
    const double difference = other[i] - best[i];
    sum += difference;
    squares += difference * difference;
  }
  const double mean = sum / n;
  return mean > std::sqrt(std::max(0.0, squares / n - mean * mean) / n);
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
  std::string reason = fmt::format(
      "probes left out are missed by {:.2f} sigma of a probe by a plane, {:.2f} by a "
      "thin plate, {:.2f} by a Gaussian process",
      plane.left_out_rms(),
      plate.left_out_rms(),
      bent.fit.left_out_rms());
  const std::vector<double> best = misses(bent.fit, kept);
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
