// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <optional>
#include <utility>

#include "surface/fit/fit.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

std::optional<Diagnostic> point_problem(const ProbePoint& point) {
  const double sigma_mm = point.measured.sigma.in_mm();
  if (point.place.in_mm().allFinite() && std::isfinite(point.measured.height.in_mm()) &&
      std::isfinite(sigma_mm) && std::isfinite(1 / sigma_mm) && sigma_mm > 0) {
    return std::nullopt;
  }
  return Diagnostic{Code::GridInvalid,
                    point.from,
                    fmt::format("probe {} has a number that is not finite, or a sigma of 0 or less",
                                quoted(point.name)),
                    "finite numbers and a sigma above 0"};
}

}  // namespace

std::string_view name_of(SurfaceModel model) {
  switch (model) {
    case SurfaceModel::Plane:
      return "plane";
    case SurfaceModel::ThinPlate:
      return "thin plate";
    case SurfaceModel::GaussianProcess:
      return "Gaussian process";
    case SurfaceModel::Bilinear:
      return "bilinear";
    case SurfaceModel::MonotoneBicubic:
      return "monotone bicubic";
  }
  return "";
}

Expected<void> check_probes(std::span<const ProbePoint> points, SurfaceModel model) {
  for (const ProbePoint& point : points) {
    if (auto problem = point_problem(point)) return failure(*std::move(problem));
  }
  const std::size_t most = is_of_grid(model) ? kMostGridProbes : kMostBentProbes;
  if (points.size() >= kPlaneTrend && points.size() <= most) return {};
  return failure({Code::GridInvalid,
                  points.empty() ? Place() : points.front().from,
                  fmt::format("{} probes", points.size()),
                  fmt::format("{} to {} for a {}{}",
                              kPlaneTrend,
                              most,
                              is_of_grid(model) ? "grid" : "surface",
                              is_of_grid(model) || points.size() <= most
                                  ? ""
                                  : ": fewer, or a complete grid and a grid model")});
}

}  // namespace panelcal
