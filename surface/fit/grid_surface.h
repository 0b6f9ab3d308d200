// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "surface/control/grid_map.h"
#include "surface/fit/left_out_probe.h"
#include "surface/fit/monotone_nodes.h"
#include "surface/fit/probe_point.h"
#include <Eigen/Core>

// Not installed: part of surface/fit/fit.h.
namespace panelcal::internal {

/// Probes of a complete rectangular grid, interpolated: every probe is believed, and nothing is
/// smoothed.
///
/// Sigma has the probes' own scatter, by their weights at the place, and what interpolation misses:
///
///   e(u, v) = c_x w^2 u (1 - u) + c_y h^2 v (1 - v)     in a cell of width w and height h
///
/// the error of a parabola with second derivatives 2 c. c_x and c_y are random, of mean 0: their
/// mean squares and their mean product are those of what the two neighbours along x, and along y,
/// predict wrongly of a node, by the product of their distances, without what scatter explains;
/// but for a standard error of that in the squares. Outside of the grid the edge holds, and sigma
/// grows with the usual slope between neighbours.
class GridSurface {
 public:
  /// Fails  grid-invalid: as GridMap::from_points(), naming the first missing node; fewer than 3
  ///        columns or rows, where nothing tells what is missed between
  static Expected<GridSurface> of(std::span<const ProbePoint> points, bool is_bicubic);

  HeightEstimate at(const Eigen::Vector2d& p_mm) const;
  /// In the order of the probes. A node is predicted by the mean of what its neighbours along x and
  /// along y do, at an edge by those along it, a corner by the parallelogram of the other three.
  std::vector<LeftOutProbe> left_out(std::span<const ProbePoint> points) const;
  /// The prior error of interpolation in the middle of the largest cell.
  Length usually_missed() const;

 private:
  struct Cell;
  explicit GridSurface(GridMap map) : map_(std::move(map)) {}
  HeightEstimate node(std::size_t i, std::size_t j) const {
    const std::size_t k = j * map_.columns_mm().size() + i;
    return {mm(nodes_[k].height), mm(sigmas_mm_[k])};
  }
  void learn();
  /// The error of interpolation, of u (1 - u) w^2 and v (1 - v) h^2.
  double missed_variance_mm2(double x_product_mm2, double y_product_mm2) const;
  Cell cell_of(const Eigen::Vector2d& inside_mm) const;
  /// The prediction of a node by the others along x, or along y; the variance is that of
  /// their scatter. Precondition: it is no first and no last one.
  struct Prediction {
    double height_mm, variance_mm2, product_mm2;
  };
  Prediction predicted(std::size_t i, std::size_t j, int axis) const;
  Prediction predicted_corner(std::size_t i, std::size_t j) const;

  GridMap map_;
  bool is_bicubic_ = false;
  std::vector<MonotoneNode> nodes_;
  std::vector<double> sigmas_mm_;
  Eigen::Vector2d curvature_per_mm_ = Eigen::Vector2d::Zero();  ///< root mean squares of c_x, c_y
  double curvatures_together_ = 0;                              ///< their mean product
  double slope_ = 0;  ///< root mean square between neighbours
};

}  // namespace panelcal::internal
