// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

// Not installed: part of surface/map/height_lattice.h and surface/fit/fit.h.
namespace panelcal::internal {

/// The data of Hermite's bicubic cell at a node.
struct MonotoneNode {
  double height = 0;
  double by_x = 0;  ///< slopes, by the unit of the coordinates
  double by_y = 0;
  double twist = 0;  ///< d2h / dx dy
};

/// Slopes and twists with which bicubic cells stay within the range of their four nodes.
///
/// In Bezier form a cell has 16 control points. Those along the sides come from slopes of Fritsch
/// and Carlson's kind: the parabola's through three nodes, 0 where the heights turn round, and at
/// most 3/2 of either neighbouring difference. With a twist of 0 the control point inside of a
/// corner is then a weighted mean of that corner and its two neighbours; the twist is the
/// parabolas', cut to what keeps all four control points about a node within the range of their
/// cells. A polynomial lies within the range of its control points, these within that of the nodes.
///
/// In     x, y: rising coordinates of columns and rows, 2 or more each; heights row by row
/// Source Fritsch and Carlson 1980; Carlson and Fritsch 1985 (bicubic); Farin 2002, 15 (range)
/// See    tests/surface/map/height_lattice_test.cc, grid_surface_test.cc
std::vector<MonotoneNode> monotone_nodes(std::span<const double> x,
                                         std::span<const double> y,
                                         std::span<const double> heights);

/// Such a slope at node i of a row.
///
/// Precondition: as many heights as coordinates, 2 or more.
double monotone_slope(std::span<const double> x, std::span<const double> heights, std::size_t i);

/// Coefficients of 1, t, t^2, t^3 from the height and the slope at t = 0 and at t = 1.
inline Eigen::Array4d hermite(double h0, double s0, double h1, double s1) {
  return {h0, s0, 3 * (h1 - h0) - 2 * s0 - s1, 2 * (h0 - h1) + s0 + s1};
}

inline double cubic_at(const Eigen::Array4d& c, double t) {
  return (c[0] + t * c[1]) + t * t * (c[2] + t * c[3]);
}

/// The cell between four nodes, of the given size: coefficients of u^0 to u^3 (rows) for v^0 to v^3
/// (columns), u and v from 0 to 1.
Eigen::Array44d bicubic_cell(const MonotoneNode& low_left,
                             const MonotoneNode& low_right,
                             const MonotoneNode& high_left,
                             const MonotoneNode& high_right,
                             double width,
                             double height);

}  // namespace panelcal::internal
