// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "calib/correction/table_basis.h"
#include "calib/table/fit_input.h"
#include "calib/table/modes.h"
#include "calib/table/system.h"
#include "calib/table/waves.h"
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

/// A weight, and its Smoother::badness().
struct LikelyWeight {
  double weight = 0;
  double badness = 0;
};

/// Normal equations with the energy of a process's waves, D.
///
///   (S + weight D) x = s,   open modes held
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

  /// Place of the maximum of the data's restricted likelihood, by golden sections; absent where no
  /// weight makes the equations definite.
  std::optional<LikelyWeight> best_weight() const;
  /// Minus twice the logarithm of the restricted likelihood, but for a constant, which is the same
  /// for all processes; infinite where the equations are not definite.
  ///
  /// The prior's determinant is that of weight D with what holds the open modes, over all that one
  /// of them touches. What none touches is as free in every process.
  double badness(double weight) const;
  std::optional<TableSolution> solve(double weight) const;

 private:
  Eigen::MatrixXd matrix(double weight) const;
  double log_determinant_of_prior(double weight) const;

  const TableWaves& waves_;
  // In waves instead of coefficients:
  Eigen::VectorXd energies_;  ///< x and y by turns
  Eigen::MatrixXd normal_;
  Eigen::MatrixXd held_normal_;  ///< with that of the holds
  Eigen::MatrixXd holds_;        ///< rows that give the open modes, times the root of their weight
  Eigen::VectorXd right_side_;   ///< with that of the holds
  Eigen::MatrixXd held_;         ///< of what is not bent, what is held: orthonormal columns
  double information_ = 1;       ///< of a coefficient, in the mean
};

/// A process and its weight.
struct LikelySmoothness {
  const TableWaves* waves = nullptr;
  double weight = 0;
};
/// Of a thin plate; enough for poses, which hardly feel the smoothness.
double usual_weight(const TableSystem& system);
/// The most likely of processes, each with its most likely weight: the first one, unless another is
/// e times as likely. Absent where none makes the equations definite.
///
/// With a thin plate alone, a table without short waves would have its long ones taken for as
/// small, where looks tell them less well: polynomials of three poses.
std::optional<LikelySmoothness> most_likely(std::span<const TableWaves> processes,
                                            const TableBasis& basis,
                                            const TableSystem& system,
                                            const OpenModes& open,
                                            const Eigen::VectorXd& before);

/// Takes the open modes out of the solution, for rounding, and out of its covariance, since no data
/// determine them; and turns the whole so that the x axis is straight. What can be turned without
/// being seen is not the table's turn alone: next to poses that are askew to the grid it has a
/// little scale in it (OpenModes::turn).
void settle(const TableBasis& basis, const OpenModes& open, TableSolution& solution);

}  // namespace panelcal::internal
