// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/correction/table_basis.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The polynomial errors of a table that measurements cannot show.
struct OpenModes {
  /// Of polynomial_modes(), orthonormal, one a column. The first three are convention and always
  /// open: both shifts and the turn.
  Eigen::MatrixXd combinations;
  /// The turn with what of the determined modes has to go with it for the data not to show it.
  Eigen::VectorXd turn;
  /// In words, without place and turn of the whole, which are convention.
  std::vector<std::string> names;
};
inline constexpr Eigen::Index kOpenTurn = 2;  ///< column of the turn

/// Finds them: combinations whose mean size (a mode of mean square 1 times a factor in mm) has a
/// sigma above `open_sigma_mm` with poses and dots free and nothing known of smoothness.
///
/// Shift and turn are open whatever the data say. Looks from beside a dot do show a turn, for the
/// camera does not turn with the table: 0.05 mm beside is enough to determine it to some hundredths
/// of a millimetre, and it would be taken for the table's then.
///
/// In     normal: of the table's coefficients, 1/mm^2
OpenModes find_open_modes(const TableBasis& basis,
                          const Eigen::MatrixXd& normal,
                          double open_sigma_mm);

/// The table's geometry from its coefficients, as a linear map; rows as TableGeometry.
Eigen::MatrixXd geometry_functionals(const TableBasis& basis);

/// The matrix that is nearest to the error, by the means over the grid: E = matrix c + ...
Eigen::Matrix2d linear_functional(const TableBasis& basis, const Eigen::VectorXd& coefficients);

/// The row whose product with the coefficients is the slope of the y error along x.
Eigen::RowVectorXd turn_functional(const TableBasis& basis);

}  // namespace panelcal::internal
