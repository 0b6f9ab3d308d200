// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/probe_readings.h"

#include <cmath>
#include <cstddef>

namespace panelcal::internal {

Readings readings_of(std::span<const ProbePoint> points) {
  Readings out;
  const auto n = static_cast<Eigen::Index>(points.size());
  out.places.resize(2, n);
  out.heights_mm.resize(n);
  out.sigmas_mm.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ProbePoint& point = points[static_cast<std::size_t>(i)];
    out.places.col(i) = point.place.in_mm();
    out.heights_mm[i] = point.measured.height.in_mm();
    out.sigmas_mm[i] = point.measured.sigma.in_mm();
    if (point.is_sigma_assumed) out.is_scatter_stated = false;
  }
  const Eigen::Vector2d low_mm = out.places.rowwise().minCoeff();
  const Eigen::Vector2d high_mm = out.places.rowwise().maxCoeff();
  out.center_mm = 0.5 * (low_mm + high_mm);
  const double half_diagonal_mm = 0.5 * (high_mm - low_mm).norm();
  if (half_diagonal_mm > 0) out.scale_mm = half_diagonal_mm;
  out.places = (out.places.colwise() - out.center_mm).eval() / out.scale_mm;
  out.mean_mm = out.heights_mm.mean();
  out.heights_mm.array() -= out.mean_mm;
  return out;
}

SurfaceShape shape_of(const Bending& bending, const Readings& readings, Eigen::Index n_trend) {
  const bool bends = bending.kernel != BendingKernel::None;
  // Stated scatter is what it is: the rest is a bending that the plane does not follow. Of its size
  // nothing was believed before, so that it is chi square that counts.
  double beyond = 0;
  if (readings.is_scatter_stated && bending.noise_factor > 1) {
    const auto n_contrasts = static_cast<double>(readings.sigmas_mm.size() - n_trend);
    constexpr double kPrior = BendingLikelihood::kPriorReadings;
    const double chi_square =
        bending.noise_factor * bending.noise_factor * (n_contrasts + kPrior) - kPrior;
    beyond = chi_square / n_contrasts - 1;
  }
  const double unresolved_mm = std::sqrt(beyond * readings.sigmas_mm.squaredNorm() /
                                         static_cast<double>(readings.sigmas_mm.size()));
  return {bending.kernel,
          mm(bends ? bending.length * readings.scale_mm : 0),
          bending.strength_mm2,
          bending.noise_factor,
          static_cast<int>(n_trend),
          mm(unresolved_mm)};
}

Bending bending_of(const SurfaceShape& shape, const Readings& readings) {
  Bending bending;
  bending.kernel = shape.kernel;
  if (shape.kernel != BendingKernel::None) {
    bending.length = shape.length.in_mm() / readings.scale_mm;
  }
  bending.strength_mm2 = shape.strength_mm2;
  bending.noise_factor = shape.noise_factor;
  return bending;
}

}  // namespace panelcal::internal
