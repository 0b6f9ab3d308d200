// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/correction/table_basis.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The polynomial errors of a table that measurements cannot show.
struct OpenModes {
  Eigen::MatrixXd combinations;  ///< of polynomial_modes(), orthonormal, one a column
  /// In words, without place and turn of the whole, which are convention.
  std::vector<std::string> names;
};

/// Finds them: combinations whose mean size (a mode of mean square 1 times a factor in mm) has a
/// sigma above `open_sigma_mm` with poses and dots free and nothing known of smoothness.
///
/// In     normal: of the table's coefficients, 1/mm^2
OpenModes find_open_modes(const TableBasis& basis,
                          const Eigen::MatrixXd& normal,
                          double open_sigma_mm);

/// The table's geometry from its coefficients, as a linear map; rows as TableGeometry.
Eigen::MatrixXd geometry_functionals(const TableBasis& basis);

/// The matrix that is nearest to the error, by the means over the grid: E = matrix c + ...
Eigen::Matrix2d linear_functional(const TableBasis& basis, const Eigen::VectorXd& coefficients);

/// Coefficients of a turn of everything by 1 rad, about the middle of the grid.
Eigen::VectorXd turn_of_all(const TableBasis& basis);
/// The row whose product with the coefficients is the slope of the y error along x.
Eigen::RowVectorXd turn_functional(const TableBasis& basis);

}  // namespace panelcal::internal
