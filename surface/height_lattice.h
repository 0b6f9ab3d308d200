// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "panelcal/calib/base/expected.h"

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
/// Each cell keeps its polynomial, so that a height takes one multiplication or three a coefficient
/// from two cache lines that lie side by side.
///
/// A bicubic cell is Hermite's, with slopes and twists that keep it within the range of its nodes:
/// parabolas', limited (surface/monotone_nodes.h).
///
/// Source Fritsch and Carlson 1980; Carlson and Fritsch 1985 (bicubic)
/// See    tests/surface/height_lattice_test.cc
class HeightLattice {
 public:
  /// In     heights_mm: row by row
  /// Fails  grid-invalid: fewer than two nodes or a step that is not positive along either axis;
  ///        not a height for each node; a number that is none
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
    double u, v;  // 0 to 1 within the cell
    bool is_outside;
  };
  using Bilinear = std::array<double, 4>;
  using Bicubic = Eigen::Array4d;  // four of them a cell: coefficients of u^0 to u^3, for each v^k

  HeightLattice(const LatticeAxis& x,
                const LatticeAxis& y,
                std::span<const double> heights_mm,
                LatticeInterpolation interpolation);

  Local local(const Eigen::Vector2d& p_mm) const;
  double bilinear_mm(const Local& at) const;
  double bicubic_mm(const Local& at) const;
  void set_bilinear(std::span<const double> heights_mm);
  void set_bicubic(std::span<const double> heights_mm);

  LatticeAxis x_, y_;
  double cells_per_x_mm_, cells_per_y_mm_;
  double below_n_columns_, below_n_rows_;
  std::size_t n_columns_, n_rows_;  // of cells
  std::vector<Bilinear> bilinear_;
  std::vector<Bicubic> bicubic_;
};

}  // namespace panelcal
