// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

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

/// Normal equations with a bending energy.
///
///   (S + weight P^order) x = s,   open modes held
///
/// P^order has the eigenvectors of P, the energy of a thin plate, and powers of its eigenvalues:
/// the spectrum of a Gaussian process falls off the steeper the higher the order. With one slope
/// alone, a table without short waves would have its long ones taken for as small, where looks tell
/// them less well: polynomials of three poses.
///
/// They are held where `before` has them: a turned table with a pose turned along is the same to
/// first order only, so what the result is turned to must be what it is solved at.
class Smoother {
 public:
  Smoother(const TableBasis& basis,
           const TableSystem& system,
           const OpenModes& open,
           const Eigen::VectorXd& before);

  /// Enough for poses, which hardly feel the smoothness.
  TableSmoothness usual() const;
  /// Place of the maximum of the data's restricted likelihood, by golden sections of the weight.
  ///
  /// In     over_orders: of all orders, rather than of a thin plate's
  TableSmoothness best(bool over_orders) const;
  std::optional<TableSolution> solve(const TableSmoothness& smoothness) const;

 private:
  /// The energy of one order.
  struct Energy {
    double order = 1;
    Eigen::MatrixXd matrix;
    double unit = 1;             ///< the weight at which bending and data weigh the same
    double log_determinant = 0;  ///< but for what is not bent or held, and a constant of all orders
  };
  struct Found {
    TableSmoothness smoothness;
    double badness = 0;
  };

  Energy energy_of(const TableBasis& basis, double order) const;
  Found best_of(const Energy& energy) const;
  double badness(const Energy& energy, double log_weight) const;
  Eigen::MatrixXd matrix(const Energy& energy, double weight) const;

  const TableSystem& system_;
  Eigen::MatrixXd functionals_;
  double information_ = 1;  ///< of a coefficient, in the mean
  double rank_ = 0;         ///< of the bending energy, but for what is held
  double hold_ = 0;         ///< weight of what holds the open modes
  Eigen::VectorXd held_at_;
  std::vector<Energy> energies_;
};

/// Takes the open modes out of the solution, for rounding, and out of its covariance, since no data
/// determine them; and turns the whole so that the x axis is straight. What can be turned without
/// being seen is not the table's turn alone: next to poses that are askew to the grid it has a
/// little scale in it (OpenModes::turn).
void settle(const TableBasis& basis, const OpenModes& open, TableSolution& solution);

}  // namespace panelcal::internal
