// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/surface/figures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "calib/base/statistics/linear_algebra.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

/// Places along each side of the area.
constexpr int kAlong = 11;

/// From -1 to 1, both ways.
std::vector<Vector2d> unit_places() {
  std::vector<Vector2d> out;
  for (int i = 0; i < kAlong * kAlong; ++i) {
    out.emplace_back(2.0 * Vector2d(i % kAlong, i / kAlong) / (kAlong - 1) - Vector2d(1, 1));
  }
  return out;
}

std::vector<Position<frame::Nominal>> area_places(const SurfaceArea& area) {
  std::vector<Position<frame::Nominal>> out;
  for (const Vector2d& unit : unit_places()) {
    out.push_back(position_mm<frame::Nominal>(area.center_mm + unit.cwiseProduct(area.half_mm)));
  }
  return out;
}

/// Figures by heights at places_of(an area).
MatrixXd figures_by_heights() {
  const std::vector<Vector2d> units = unit_places();
  MatrixXd heights_by_figures(static_cast<Index>(units.size()), SurfaceFigures::kSize);
  for (std::size_t i = 0; i < units.size(); ++i) {
    const double u = units[i].x(), v = units[i].y();
    heights_by_figures.row(static_cast<Index>(i)) << 1, u, v, u * u, v * v, u * v;
  }
  const double rounding = std::numeric_limits<double>::epsilon() * SurfaceFigures::kSize;
  return internal::pseudo_inverse(heights_by_figures, rounding).matrix;
}

/// To a tenth, of which zero has no sign.
double shown(double value) {
  return std::round(10 * value) / 10 + 0.0;
}

/// Checks that the map gives heights at all corners.
Expected<void> reaches_over(const HeightMap& map, const SurfaceArea& area) {
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      const Vector2d corner_mm = area.center_mm + Vector2d(x, y).cwiseProduct(area.half_mm);
      PANELCAL_CHECK(map.height_at(position_mm<frame::Nominal>(corner_mm)));
    }
  }
  return {};
}

}  // namespace

Expected<SurfaceFigures> figures_of(const HeightMap& map, const SurfaceArea& area) {
  if (is_of_grid(map.surface().model())) {
    return failure({Code::GridInvalid,
                    {},
                    fmt::format("the map's model is {}, which has no covariance of its errors",
                                name_of(map.surface().model())),
                    "a Gaussian process, a thin plate or a plane"});
  }
  PANELCAL_CHECK(reaches_over(map, area));
  const auto places = area_places(area);
  const std::vector<double> heights_mm = map.surface().heights_mm(places);
  const MatrixXd by_heights = figures_by_heights();
  SurfaceFigures out;
  out.area = area;
  out.value_mm = by_heights * VectorXd::Map(heights_mm.data(), by_heights.cols());
  const MatrixXd cov_mm2 = internal::propagated(by_heights, map.surface().covariance_mm2(places));
  // A coefficient that a model leaves no room for (the bow of a plane) has no variance, and by
  // rounding less.
  const internal::Eigensystem eigen = internal::eigensystem(0.5 * (cov_mm2 + cov_mm2.transpose()));
  const MatrixXd root = eigen.vectors * eigen.values.cwiseMax(0).cwiseSqrt().asDiagonal();
  out.cov_mm2 = root * root.transpose();
  out.cov_mm2 = 0.5 * (out.cov_mm2 + out.cov_mm2.transpose()).eval();
  return out;
}

Length largest_sigma(const HeightMap& map, const SurfaceArea& area) {
  Length largest;
  for (const auto& place : area_places(area)) {
    const auto height = map.height_at(place);
    // One that cannot be had has to fail.
    if (!height) return mm(std::numeric_limits<double>::infinity());
    largest = std::max(largest, height->sigma);
  }
  return largest;
}

SurfaceArea area_of(const HeightMap& map) {
  Vector2d low_mm = map.hull().front().in_mm(), high_mm = low_mm;
  for (const auto& corner : map.hull()) {
    low_mm = low_mm.cwiseMin(corner.in_mm());
    high_mm = high_mm.cwiseMax(corner.in_mm());
  }
  return {0.5 * (low_mm + high_mm), 0.5 * (high_mm - low_mm)};
}

std::string report(const SurfaceFigures& figures) {
  std::string out;
  for (int i = 0; i < SurfaceFigures::kSize; ++i) {
    std::string name(SurfaceFigures::kNames[static_cast<std::size_t>(i)]);
    std::ranges::replace(name, '_', ' ');
    const double value_um = shown(1e3 * figures.value_mm[i]);
    const double sigma_um = 1e3 * std::sqrt(figures.cov_mm2(i, i));
    std::string slope;
    if (i == 1 || i == 2) {
      const double slope_um_m = 1e6 * figures.value_mm[i] / figures.area.half_mm[i - 1];
      slope = fmt::format(" ({:+.1f} um/m)", shown(slope_um_m));
    }
    out += fmt::format("{:<11}{:+.1f} um +- {:.1f}{}\n", name, value_um, sigma_um, slope);
  }
  return out;
}

}  // namespace panelcal
