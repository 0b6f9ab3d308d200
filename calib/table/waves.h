// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/correction/table_basis.h"
#include "calib/table/fit_input.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The error of a table, one coordinate of it, as a Gaussian process in independent waves.
struct TableWaves {
  /// The first waves, which are linear in the place: any size of them is as likely.
  static constexpr Eigen::Index kUnbent = 3;

  TableProcess process = TableProcess::ThinPlate;
  double length = 0;
  Eigen::MatrixXd shapes;    ///< coefficients of each wave, one a column, orthonormal
  Eigen::VectorXd energies;  ///< 1 over the variance of each, times one number; unbent: 0

  /// Waves of both coordinates.
  Eigen::Index size() const { return 2 * shapes.cols(); }
};

/// Eigenvectors of a thin plate's bending energy, which has a variance of every wave.
TableWaves plate_waves(const TableBasis& basis);

/// Those of a covariance that falls with the distance: of a process `length` times the grid's
/// longer side. Waves of less than 1e-10 of the largest variance are left out.
///
/// A thin plate has its natural edges, at which no table keeps to straight lines; a process that is
/// alike everywhere has none. Coefficients are the values of a process at their places, so the
/// error is that process seen through a B-spline.
///
/// Source Rasmussen and Williams 2006, Gaussian Processes for Machine Learning, 4.2.1
TableWaves matern_waves(const TableBasis& basis, double length);

/// All that a table is held against: a thin plate first.
std::vector<TableWaves> all_waves(const TableBasis& basis);

}  // namespace panelcal::internal
