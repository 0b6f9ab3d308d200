// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "vision/fit/coverage.h"
#include "vision/render/outline_circle.h"
#include "vision/render/scene.h"
#include "vision/render/scene_projection.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// A straight piece of an outline, mm on the board. The inside, which weighs `weight` more than the
/// outside, is to the left of the way.
struct Side {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
  double weight = 1;
};

/// A piece of a circle, or all of it; the inside is to the left if the angle grows.
struct Arc {
  Eigen::Vector2d center;
  RoughCircle rim;
  double from_rad = 0;
  double to_rad = 0;

  /// A closed curve has no ends to look after.
  bool is_closed() const;
  Eigen::Vector2d at(double angle_rad) const;
  Eigen::Vector2d derivative(double angle_rad) const;
};

struct Outline {
  std::vector<Side> sides;
  std::vector<Arc> arcs;
};

/// The outline of any feature; for Cells that of the opaque ones together.
Outline outline_of(const Feature& feature);

/// The edges of a grid's cells, weighted by what the cells differ by; outside of the grid is 0.
///
/// In     feature: with cells; values: one for each of them
Outline cell_edges(const Feature& feature, std::span<const double> values);

/// Quadrature nodes along an outline; empty if the lens model cannot draw it.
///
/// Closed arcs have equally spaced nodes: the trapezoid rule converges exponentially on smooth
/// closed curves (Trefethen and Weideman 2014). Everything else has Gauss-Legendre panels. The
/// error is below 1e-7 of a pixel's share.
std::vector<OutlineNode> outline_nodes(const SceneProjection& projection,
                                       const Outline& outline,
                                       double blur_px);

/// Places along an outline, about `spacing` apart, mm.
std::vector<Eigen::Vector2d> outline_places(const Outline& outline, Length spacing);

}  // namespace panelcal::internal
