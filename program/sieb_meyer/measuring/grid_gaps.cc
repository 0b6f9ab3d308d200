// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/measuring/grid_gaps.h"

#include <algorithm>

#include "surface/map/height_map.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

/// A perfect board is probed exactly, of which no map can be made.
constexpr Length kLeastSigma = um(0.1);

/// The distinct coordinates along one axis, rising.
std::vector<double> coordinates_mm(std::span<const GridPoint> points, Eigen::Index axis) {
  std::vector<double> all_mm;
  for (const GridPoint& point : points) all_mm.push_back(point.place_mm[axis]);
  std::ranges::sort(all_mm);
  std::vector<double> kept_mm;
  for (const double v_mm : all_mm) {
    const bool is_new = kept_mm.empty() || v_mm - kept_mm.back() > GridMap::kSamePlace.in_mm();
    if (is_new) kept_mm.push_back(v_mm);
  }
  return kept_mm;
}

bool is_at(const GridPoint& point, const Eigen::Vector2d& node_mm) {
  return (point.place_mm - node_mm).cwiseAbs().maxCoeff() <= GridMap::kSamePlace.in_mm();
}

/// Of all nodes; more are no gaps, but points that lie beside the lattice.
constexpr double kMostMissing = 0.25;

}  // namespace

std::vector<Eigen::Vector2d> missing_nodes(std::span<const GridPoint> points) {
  std::vector<Eigen::Vector2d> missing;
  for (const double y_mm : coordinates_mm(points, 1)) {
    for (const double x_mm : coordinates_mm(points, 0)) {
      const Eigen::Vector2d node_mm(x_mm, y_mm);
      const bool is_there =
          std::ranges::any_of(points, [&](const GridPoint& p) { return is_at(p, node_mm); });
      if (!is_there) missing.push_back(node_mm);
    }
  }
  return missing;
}

Expected<std::vector<FilledNode>> fill_nodes(std::span<const GridPoint> points,
                                             std::span<const Eigen::Vector2d> nodes_mm,
                                             Length max_extrapolation) {
  if (points.size() < kLeastForBow) {
    return failure(
        {Code::GridInvalid,
         {},
         fmt::format("{} points do not determine how the board bends where one is missing",
                     points.size()),
         fmt::format("{} or more", kLeastForBow)});
  }
  if (static_cast<double>(nodes_mm.size()) >
      kMostMissing * static_cast<double>(points.size() + nodes_mm.size())) {
    return failure({Code::GridInvalid,
                    {},
                    fmt::format("{} of {} nodes are missing, so that the points hardly make a grid",
                                nodes_mm.size(),
                                points.size() + nodes_mm.size()),
                    "at most a quarter"});
  }
  std::vector<FilledNode> filled;
  for (const Eigen::Vector2d& node_mm : nodes_mm) {
    filled.push_back({.line = 0,
                      .place = position_mm<frame::Nominal>(node_mm),
                      .heights = {},
                      .source = HeightSource::Filled});
  }
  HeightMapOptions options;
  options.max_extrapolation = max_extrapolation;
  for (std::size_t axis = 0; axis < points.front().heights.size(); ++axis) {
    std::vector<ProbePoint> probes;
    for (const GridPoint& point : points) {
      HeightEstimate height = point.heights[axis];
      height.sigma = std::max(height.sigma, kLeastSigma);
      probes.push_back({position_mm<frame::Nominal>(point.place_mm), height, "G79 point", {}});
    }
    PANELCAL_TRY(const HeightMap map, HeightMap::of_probes(probes, options));
    for (FilledNode& node : filled) {
      PANELCAL_TRY(const HeightAt found, map.height_at(node.place));
      node.heights.push_back({found.height, found.sigma});
      if (found.outside > Length()) node.source = HeightSource::Extrapolated;
    }
  }
  return filled;
}

}  // namespace panelcal::sieb_meyer
