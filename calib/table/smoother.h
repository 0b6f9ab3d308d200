// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/correction/table_basis.h"
#include "calib/table/fit_input.h"
#include "calib/table/modes.h"
#include "calib/table/system.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The smoothest table that the data allow, and how well it is known.
struct TableSolution {
  Eigen::VectorXd table_mm;
  Eigen::MatrixXd cov;
  TableSmoothness smoothness;
  double parameters = 0;  ///< trace of the smoother H
  double taken_up = 0;    ///< trace of 2 H - H^2: so much less than their number residuals are
};

/// A thin plate's waves over the table: eigenvectors of its bending energy P, in which every power
/// of P is diagonal. The first three, which are linear in the place, are not bent.
struct TableWaves {
  static constexpr Eigen::Index kUnbent = 3;

  explicit TableWaves(const TableBasis& basis);

  Eigen::Index size() const { return 2 * shapes.rows(); }
  /// Of the coefficients of one coordinate, one wave a column.
  Eigen::MatrixXd shapes;
  /// Of P, for each wave; 1 in the mean.
  Eigen::VectorXd energies;
};

/// Normal equations with a bending energy.
///
///   (S + weight P^order) x = s,   open modes held
///
/// The higher the order, the steeper the spectrum of the Gaussian process that the energy stands
/// for. With one slope alone, a table without short waves would have its long ones taken for as
/// small, where looks tell them less well: polynomials of three poses.
///
/// Open modes are held where `before` has them: a turned table with a pose turned along is the same
/// to first order only, so what the result is turned to must be what it is solved at.
class Smoother {
 public:
  Smoother(const TableWaves& waves,
           const TableBasis& basis,
           const TableSystem& system,
           const OpenModes& open,
           const Eigen::VectorXd& before);

  /// Enough for poses, which hardly feel the smoothness.
  TableSmoothness usual() const;
  /// Place of the maximum of the data's restricted likelihood, by golden sections of the weight;
  /// absent where no weight makes the equations definite.
  ///
  /// In     over_orders: of all orders, else of order 1. A higher one has to be e times as likely
  std::optional<TableSmoothness> best(bool over_orders) const;
  /// Minus twice the logarithm of the restricted likelihood, but for a constant, which is the same
  /// for all; infinite where the equations are not definite.
  ///
  /// The prior's determinant is that of weight P^order with what holds the open modes, over all
  /// that one of them touches. What none touches is free in every order alike.
  double badness(const TableSmoothness& smoothness) const;
  std::optional<TableSolution> solve(const TableSmoothness& smoothness) const;

 private:
  /// Of each wave in both coordinates, by turns.
  Eigen::VectorXd powers(double order) const;
  Eigen::MatrixXd matrix(const TableSmoothness& smoothness) const;
  double log_determinant_of_prior(const TableSmoothness& smoothness) const;
  TableSmoothness best_of(double order) const;

  const TableWaves& waves_;
  // In waves instead of coefficients:
  Eigen::MatrixXd normal_;
  Eigen::MatrixXd holds_;       ///< rows that give the open modes, times the root of their weight
  Eigen::VectorXd right_side_;  ///< with that of the holds
  Eigen::MatrixXd free_;        ///< of what is not bent, what is not held: orthonormal columns
  double information_ = 1;      ///< of a coefficient, in the mean
};

/// Takes the open modes out of the solution, for rounding, and out of its covariance, since no data
/// determine them; and turns the whole so that the x axis is straight. What can be turned without
/// being seen is not the table's turn alone: next to poses that are askew to the grid it has a
/// little scale in it (OpenModes::turn).
void settle(const TableBasis& basis, const OpenModes& open, TableSolution& solution);

}  // namespace panelcal::internal
