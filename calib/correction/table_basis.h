// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "calib/correction/spline_weights.h"
#include "calib/correction/table_map.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// One axis: steps of a grid from 0 to `steps`, and the polynomials on it.
///
/// Polynomials are Legendre's with a mean square of 1 over the axis; degree 0 to 3, all of which a
/// cubic spline can follow exactly.
struct AxisBasis {
  explicit AxisBasis(int steps);

  Eigen::MatrixXd polynomials;  ///< coefficients that make the spline the polynomial; by degree
  Eigen::MatrixXd moments;      ///< mean over the axis of polynomial times B-spline; by degree
  /// Integrals over the axis of products of B-splines, of their slopes, of their curvatures, with
  /// the axis counted in steps.
  std::array<Eigen::MatrixXd, 3> grams;
};

/// A polynomial error of the table: mode(commanded) along x or y with mean square 1.
struct PolynomialMode {
  int coordinate = 0;  ///< 0: of the x error
  int x_degree = 0;
  int y_degree = 0;
};

/// All with a degree of at most 3 in all, lowest first.
std::vector<PolynomialMode> polynomial_modes();

/// The 16 coefficients of one coordinate that matter at a place, and their weights.
struct LocalWeights {
  std::array<Eigen::Index, 16> index;
  std::array<double, 16> weight;
};
/// Precondition: finite.
LocalWeights local_of(const TableGrid& grid, const Eigen::Vector2d& commanded_mm);

/// The parts of a table's error. Coefficients are ordered as TableMap's, x and y by turns.
struct TableBasis {
  explicit TableBasis(const TableGrid& grid);

  TableGrid grid;
  Eigen::MatrixXd modes;        ///< coefficients of each polynomial mode, one a column
  Eigen::MatrixXd functionals;  ///< the share of each mode in an error, one a row
  Eigen::MatrixXd bending;      ///< energy of a thin plate, of one coordinate, no unit

  Eigen::Index size() const { return 2 * grid.n_coefficients(); }
};

}  // namespace panelcal::internal
