// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/correction/table_basis.h"
#include "calib/table/modes.h"
#include "calib/table/system.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The smoothest table that the data allow, and how well it is known.
struct TableSolution {
  Eigen::VectorXd table_mm;
  Eigen::MatrixXd cov;
  double smoothing = 0;   ///< weight of the bending energy
  double parameters = 0;  ///< trace of the smoother H
  double taken_up = 0;    ///< trace of 2 H - H^2: so much less than their number residuals are
};

/// Normal equations with a bending energy.
///
///   (S + smoothing P) x = s,   open modes held
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
  double usual() const { return 1e-4 * unit_; }
  /// Place of the maximum of the data's restricted likelihood, by golden sections.
  double best() const;
  std::optional<TableSolution> solve(double smoothing) const;

 private:
  double badness(double log_smoothing) const;
  Eigen::MatrixXd matrix(double smoothing) const;

  const TableSystem& system_;
  Eigen::MatrixXd functionals_;
  Eigen::MatrixXd bending_;
  double unit_ = 1;  ///< the smoothing at which bending and data weigh the same
  double rank_ = 0;  ///< of the bending energy, but for what is held
  double hold_ = 0;  ///< weight of what holds the open modes
  Eigen::VectorXd held_at_;
};

/// Takes the open modes out of the solution, for rounding, and out of its covariance, since no data
/// determine them; and turns the whole so that the x axis is straight. What can be turned without
/// being seen is not the table's turn alone: next to poses that are askew to the grid it has a
/// little scale in it (OpenModes::turn).
void settle(const TableBasis& basis, const OpenModes& open, TableSolution& solution);

}  // namespace panelcal::internal
