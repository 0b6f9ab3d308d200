// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "surface/control/reference_plane.h"
#include <Eigen/Core>
#include <tl/expected.hpp>

namespace panelcal {

/// A probed place of the grid: nominal, mm, and one height per Z axis, the first axis first.
struct GridPoint {
  Eigen::Vector2d place_mm;
  std::vector<HeightEstimate> heights;
};

/// The reason why points make no grid.
enum class GridFailure : std::uint8_t {
  TooFewPoints,  ///< fewer than two columns or fewer than two rows
  Incomplete,    ///< a node of the lattice has no point
  Duplicate,     ///< two points on one node
  BadPoint,      ///< another number of Z axes than the first point; a number that is not finite
};

/// The problem, its point, and the remedy.
struct GridProblem {
  GridFailure failure = GridFailure::TooFewPoints;
  std::string text;
  std::optional<std::size_t> i_point;  ///< the second of two, or the bad one
};

/// A height from the grid.
struct GridHeight {
  std::vector<HeightEstimate> heights;  ///< one per Z axis
  /// Distance of the place from the grid, outside of which the edge value holds; 0 inside.
  Length outside;

  bool is_inside() const { return outside == Length(); }
};

/// Heights probed on an axis-parallel lattice, interpolated between its nodes.
///
/// Within a cell the height is bilinear; outside of the grid the nearest edge value holds. Columns
/// and rows need not be evenly spaced; nominal coordinates, mm.
///
/// Source SIEB & MEYER CNC 8x.00, surface detection in the grid; semantics page, Surface
/// See    tests/surface/control/grid_map_test.cc
class GridMap {
 public:
  /// Coordinates that differ by less are of the same column or row; a place that lies outside by
  /// less is inside.
  static constexpr Length kSamePlace = um(1);

  /// Makes the map of points in any order.
  ///
  /// Fails  TooFewPoints; Incomplete (names the first missing node: lowest row, then leftmost);
  ///        Duplicate (also of equal heights: a grid that runs twice over a node was programmed
  ///        wrongly); BadPoint (heights must be finite, sigmas 0 or more)
  /// Cost   O(n log n)
  static tl::expected<GridMap, GridProblem> from_points(std::span<const GridPoint> points);

  std::size_t n_axes() const { return n_axes_; }
  std::span<const double> columns_mm() const { return x_mm_; }
  std::span<const double> rows_mm() const { return y_mm_; }

  /// The height at a place, its sigma from the sigmas of the nodes as independent errors.
  ///
  /// Precondition: p_mm is finite.
  GridHeight height_at(const Eigen::Vector2d& p_mm) const;

  /// Parameters at which a straight contour must be cut, so that a tool that goes straight from the
  /// map's height at one cut to that at the next stays within `tolerance` of the map on every Z
  /// axis.
  ///
  /// Between cell borders the height is a quadratic a t^2 + b t + c, which a chord over a stretch
  /// of length h in t misses by a h^2 / 4 in its middle. A chord over borders is also off at these:
  /// in between its error is between those at both borders, but for that bow. Each cut is put as
  /// far from the one before as this allows, so a border is cut only where it matters.
  ///
  /// In     tolerance: below 0.001 um it counts as 0.001 um
  /// Out    rising parameters t, 0 < t < 1, of from + t (to - from); none if nothing need be cut or
  ///        a number is not finite. Between two borders there are at most 4096 stretches, whatever
  ///        the tolerance.
  /// Cost   O(n b + b^2), n cuts, b borders
  std::vector<double> split_line(const Eigen::Vector2d& from_mm,
                                 const Eigen::Vector2d& to_mm,
                                 Length tolerance) const;

  /// The same for an arc, whose height is to change linearly with the angle.
  ///
  ///   h = c + r (gx cos w + gy sin w) + 1/2 k r^2 sin 2w
  ///
  /// in a cell, with slopes gx, gy at the centre and twist k. The second derivative's range over a
  /// stretch takes the part of a: the sum of both terms' ranges, so that some cuts more are made
  /// than needed (a fifth: tests/surface/control/grid_split_slow_test.cc).
  ///
  /// In     sweep_rad: signed, counter-clockwise is positive; at most a full turn
  /// Out    rising fractions t of the sweep, 0 < t < 1, otherwise as split_line()
  std::vector<double> split_arc(const Eigen::Vector2d& center_mm,
                                double start_angle_rad,
                                double sweep_rad,
                                double radius_mm,
                                Length tolerance) const;

 private:
  /// The height about a place: h + x X + y Y + twist X Y, with X and Y from there. Beyond the edge
  /// of the grid the height does not change with the coordinate that is outside.
  struct CellForm {
    double x = 0;
    double y = 0;
    double twist_per_mm = 0;
  };
  /// Between which d2h / dt2 is, mm.
  struct Bend {
    double low_mm = 0;
    double high_mm = 0;
  };
  static Bend bend_of_cosine(double amplitude_mm, double a_rad, double b_rad);
  using BendOfCell = std::function<Bend(const CellForm&, double t0, double t1)>;
  struct Profile;

  GridMap() = default;
  const HeightEstimate& node(std::size_t ix, std::size_t iy, std::size_t axis) const {
    return nodes_[(iy * x_mm_.size() + ix) * n_axes_ + axis];
  }
  Eigen::Vector2d nearest_inside(const Eigen::Vector2d& p_mm) const;
  /// In     p_mm: a place in the cell
  CellForm form_at(const Eigen::Vector2d& p_mm,
                   const Eigen::Vector2d& about_mm,
                   std::size_t axis) const;
  Eigen::ArrayXd heights_mm(const Eigen::Vector2d& p_mm) const;
  /// In     knots: where the contour crosses a border; about_mm: of the forms that `bend` gets
  std::vector<double> split(std::vector<double> knots,
                            const std::function<Eigen::Vector2d(double)>& place_mm,
                            const Eigen::Vector2d& about_mm,
                            const BendOfCell& bend,
                            Length tolerance) const;

  std::size_t n_axes_ = 0;
  std::vector<double> x_mm_;           // of the columns, rising
  std::vector<double> y_mm_;           // of the rows, rising
  std::vector<HeightEstimate> nodes_;  // by row, column and Z axis
};

}  // namespace panelcal
