// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <optional>
#include <utility>

#include "surface/fit/fit.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// A picometre: squares of what is finite over less may not be.
constexpr double kLeastSigma_mm = 1e-9;
constexpr double kMostProbed_mm = 1e6;

std::optional<Diagnostic> point_problem(const ProbePoint& point) {
  const double sigma_mm = point.measured.sigma.in_mm();
  const double height_mm = point.measured.height.in_mm();
  // A NaN fails every comparison.
  if (point.place.in_mm().cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= kMostProbed_mm &&
      std::abs(height_mm) <= kMostProbed_mm && sigma_mm >= kLeastSigma_mm &&
      sigma_mm <= kMostProbed_mm) {
    return std::nullopt;
  }
  return Diagnostic{Code::GridInvalid,
                    point.from,
                    fmt::format("probe {} is at ({:.6g}, {:.6g}) mm, height {:.6g} +- {:.3g} mm",
                                quoted(point.name),
                                point.place.in_mm().x(),
                                point.place.in_mm().y(),
                                height_mm,
                                sigma_mm),
                    "places and heights within 1e6 mm of 0, sigmas of 1e-9 to 1e6 mm"};
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
