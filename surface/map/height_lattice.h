// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "calib/base/expected.h"
#include <Eigen/Core>

namespace panelcal {

enum class LatticeInterpolation : std::uint8_t {
  Bilinear,
  MonotoneBicubic,  ///< smooth, and nowhere outside of the range of the cell's four nodes
};

/// Evenly spaced columns or rows.
struct LatticeAxis {
  double first_mm = 0;
  double step_mm = 1;
  int n_nodes = 2;

  double at_mm(int i_node) const { return first_mm + i_node * step_mm; }
  double last_mm() const { return at_mm(n_nodes - 1); }
};

/// Heights at the nodes of an evenly spaced lattice, interpolated very fast.
///
/// Speed is what memory gives, so the nodes are kept and no cell's polynomial. Processors with AVX2
/// take four places at once; heights are the same to the bit on every machine.
///
/// A bicubic cell is Hermite's, with slopes and twists that keep it within the range of its nodes:
/// parabolas', limited (surface/fit/monotone_nodes.h).
///
/// Source Fritsch and Carlson 1980; Carlson and Fritsch 1985 (bicubic)
/// See    tests/surface/map/height_lattice_test.cc
class HeightLattice {
 public:
  /// In     heights_mm: row by row
  /// Fails  grid-invalid: fewer than two nodes or a step that is not positive along either axis;
  ///        not a height for each node; a number that is not finite
  static Expected<HeightLattice> make(const LatticeAxis& x,
                                      const LatticeAxis& y,
                                      std::span<const double> heights_mm,
                                      LatticeInterpolation interpolation);

  const LatticeAxis& x() const { return x_; }
  const LatticeAxis& y() const { return y_; }
  std::size_t n_cells() const { return n_columns_ * n_rows_; }
  /// The cell of a place, row by row; of the nearest place inside if it lies outside.
  std::size_t cell_of(const Eigen::Vector2d& p_mm) const;
  bool is_inside(const Eigen::Vector2d& p_mm) const;

  /// The height at a place, or of the nearest one inside.
  double height_mm(const Eigen::Vector2d& p_mm) const;
  /// The same for many places.
  ///
  /// In     cell_marks: empty, or one for each cell
  ///        heights_mm: one for each place; of spans of different sizes the first ones are taken
  /// Out    whether any place lies outside or in a cell with a mark, or sizes differ: whether a
  ///        second look is due
  bool heights_mm(std::span<const Eigen::Vector2d> places_mm,
                  std::span<double> heights_mm,
                  std::span<const std::uint8_t> cell_marks) const;

 private:
  struct Local {
    std::size_t cell;
    std::size_t node;  // the cell's first one
    double u, v;       // 0 to 1 within the cell
    bool is_outside;
  };
  /// Finds cells. Small and by itself: a loop has its own copy, which no height that is written
  /// there could change.
  struct Finder {
    /// In steps: a place that lies outside by rounding is inside.
    static constexpr double kSameNode = 1e-11;

    double first_x_mm, first_y_mm;
    double cells_per_x_mm, cells_per_y_mm;
    double below_n_columns, below_n_rows;
    std::size_t n_columns;

    Local local(const Eigen::Vector2d& p_mm) const;
  };
  struct Bilinear;
  struct Bicubic;
  struct Fours;

  HeightLattice(const LatticeAxis& x,
                const LatticeAxis& y,
                std::span<const double> heights_mm,
                LatticeInterpolation interpolation);

  Bilinear bilinear() const;
  Bicubic bicubic() const;
  void set_bicubic(std::span<const double> heights_mm);
  /// heights_mm() of the first places, in fours, on a processor that can
  /// (surface/map/height_lattice_avx2.cc).
  ///
  /// In     cell_marks: null, or one for each cell
  /// Out    how many places; is_due: whether a second look at any of them is
  std::size_t heights_in_fours(std::span<const Eigen::Vector2d> places_mm,
                               double* heights_mm,
                               const std::uint8_t* cell_marks,
                               bool& is_due) const;

  LatticeAxis x_, y_;
  std::size_t n_columns_, n_rows_;  // of cells
  Finder finder_;
  std::vector<double> nodes_mm_;  // if bilinear
  // If bicubic, for each node, mm by step: height and slope along x; slope along y and twist.
  std::vector<double> heights_mm_, slopes_mm_;
};

}  // namespace panelcal
