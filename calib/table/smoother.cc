// SPDX-License-Identifier: Apache-2.0
#include "calib/table/smoother.h"

#include <array>
#include <cmath>
#include <limits>

#include "calib/base/statistics/linear_algebra.h"

namespace panelcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Weights that are tried. The least: of waves of the mean energy, a part of the data's
/// information. The most: of the longest bent wave, a multiple of it.
constexpr double kLeastWeight = 1e-12;
constexpr double kMostWeight = 1e6;
constexpr double kUsualWeight = 1e-4;
constexpr int kSearchSteps = 18;  ///< of golden sections: the logarithm to 0.01
/// A thin plate's, and those of smoother surfaces. Four times as steep is as good as no short wave.
constexpr std::array kOrders = {1.0, 1.5, 2.0, 3.0};
/// Twice the logarithm of how many times as likely a higher order has to be.
constexpr double kClearlyLess = 2;
/// Singular values of the unbent part of the open modes, which are orthonormal or 0.
constexpr double kHeld = 1e-6;

/// M with each coordinate's rows multiplied: out = (U x 1)' M, x and y by turns.
MatrixXd of_waves(const MatrixXd& shapes, const MatrixXd& m) {
  MatrixXd out(m.rows(), m.cols());
  for (Index c = 0; c < 2; ++c) {
    const auto rows = Eigen::seqN(c, shapes.rows(), Eigen::fix<2>);
    out(rows, Eigen::all) = shapes.transpose() * MatrixXd(m(rows, Eigen::all));
  }
  return out;
}

MatrixXd of_coefficients(const MatrixXd& shapes, const MatrixXd& m) {
  return of_waves(shapes.transpose(), m);
}

}  // namespace

TableWaves::TableWaves(const TableBasis& basis) {
  const Eigensystem bending = eigensystem(basis.bending);
  shapes = bending.vectors;
  energies = bending.values / bending.values.mean();
  energies.head(kUnbent).setZero();
}

Smoother::Smoother(const TableWaves& waves,
                   const TableBasis& basis,
                   const TableSystem& system,
                   const OpenModes& open,
                   const VectorXd& before)
    : waves_(waves) {
  const MatrixXd half = of_waves(waves.shapes, system.normal());
  normal_ = of_waves(waves.shapes, half.transpose());
  information_ = system.normal().trace() / static_cast<double>(waves.size());
  // Of modes of mean square 1 the functionals are short where the coefficients are many.
  const double hold = std::sqrt(information_ * static_cast<double>(waves.size()));
  const MatrixXd functionals = open.combinations.transpose() * basis.functionals;
  holds_ = hold * of_waves(waves.shapes, functionals.transpose()).transpose();
  right_side_ = of_waves(waves.shapes, system.right_side()) +
                holds_.transpose() * (hold * (functionals * before));
  const MatrixXd unbent = holds_.leftCols(2 * TableWaves::kUnbent) / hold;
  const Eigensystem held = eigensystem(unbent.transpose() * unbent);
  const double most = held.values.tail(1).value();
  const Index n_free = (held.values.array() <= kHeld * kHeld * most).count();
  free_ = held.vectors.leftCols(n_free);
}

VectorXd Smoother::powers(double order) const {
  VectorXd out(waves_.size());
  for (Index k = 0; k < waves_.energies.size(); ++k) {
    out[2 * k] = out[2 * k + 1] = k < TableWaves::kUnbent ? 0 : std::pow(waves_.energies[k], order);
  }
  return out;
}

MatrixXd Smoother::matrix(const TableSmoothness& smoothness) const {
  MatrixXd out = normal_ + holds_.transpose() * holds_;
  out.diagonal() += smoothness.weight * powers(smoothness.order);
  return out;
}

/// By Sylvester's identity and Schur's complement over what is not bent, so that the small energies
/// of long waves are not lost beside the large ones of short waves:
///
///   |D + B'B| |N' (1 + B D^-1 B')^-1 N|,   |D + B'B| = |D| |1 + B D^-1 B'|
///
/// D is the energy of bent waves, and [N B] holds the open modes.
double Smoother::log_determinant_of_prior(const TableSmoothness& smoothness) const {
  const Index n_unbent = 2 * TableWaves::kUnbent;
  const Index n_bent = waves_.size() - n_unbent;
  const VectorXd energies = smoothness.weight * powers(smoothness.order).tail(n_bent);
  const MatrixXd bent = holds_.rightCols(n_bent);
  const MatrixXd unbent = holds_.leftCols(n_unbent);
  MatrixXd of_holds = bent * energies.cwiseInverse().asDiagonal() * bent.transpose();
  of_holds.diagonal().array() += 1;
  const Cholesky held(of_holds);
  const MatrixXd left =
      unbent.transpose() * held.solve(unbent) + information_ * free_ * free_.transpose();
  return energies.array().log().sum() + held.log_determinant() + Cholesky(left).log_determinant();
}

double Smoother::badness(const TableSmoothness& smoothness) const {
  const Cholesky decomposed(matrix(smoothness));
  constexpr double kWorst = std::numeric_limits<double>::infinity();
  if (!decomposed.is_definite()) return kWorst;
  const double explained = right_side_.dot(decomposed.solve(right_side_));
  const double badness =
      decomposed.log_determinant() - log_determinant_of_prior(smoothness) - explained;
  return std::isfinite(badness) ? badness : kWorst;
}

TableSmoothness Smoother::usual() const {
  return {1, kUsualWeight * information_};
}

TableSmoothness Smoother::best_of(double order) const {
  const auto at = [&](double log_weight) { return TableSmoothness{order, std::exp(log_weight)}; };
  const double golden = (std::sqrt(5.0) - 1) / 2;
  const VectorXd energies = powers(order);
  double low = std::log(kLeastWeight * information_ / energies.mean());
  double high = std::log(kMostWeight * information_ / energies[2 * TableWaves::kUnbent]);
  double a = high - golden * (high - low);
  double b = low + golden * (high - low);
  double at_a = badness(at(a));
  double at_b = badness(at(b));
  for (int i = 0; i < kSearchSteps; ++i) {
    if (at_a < at_b) {
      high = b;
      b = a;
      at_b = at_a;
      a = high - golden * (high - low);
      at_a = badness(at(a));
    } else {
      low = a;
      a = b;
      at_a = at_b;
      b = low + golden * (high - low);
      at_b = badness(at(b));
    }
  }
  return at(0.5 * (low + high));
}

std::optional<TableSmoothness> Smoother::best(bool over_orders) const {
  TableSmoothness best = best_of(kOrders.front());
  double least = badness(best);
  for (std::size_t k = 1; over_orders && k < kOrders.size(); ++k) {
    const TableSmoothness next = best_of(kOrders[k]);
    const double badness_of_next = badness(next);
    if (!(badness_of_next < least - kClearlyLess)) continue;
    best = next;
    least = badness_of_next;
  }
  if (!std::isfinite(least)) return std::nullopt;
  return best;
}

std::optional<TableSolution> Smoother::solve(const TableSmoothness& smoothness) const {
  const Cholesky decomposed(matrix(smoothness));
  if (!decomposed.is_definite()) return std::nullopt;
  TableSolution out;
  out.smoothness = smoothness;
  const MatrixXd& shapes = waves_.shapes;
  out.table_mm = of_coefficients(shapes, decomposed.solve(right_side_));
  const MatrixXd cov = decomposed.inverse();
  out.cov = of_coefficients(shapes, of_coefficients(shapes, cov).transpose());
  const MatrixXd share = cov * normal_;
  out.parameters = share.trace();
  out.taken_up = 2 * out.parameters - share.cwiseProduct(share.transpose()).sum();
  if (!out.table_mm.allFinite() || !out.cov.allFinite()) return std::nullopt;
  return out;
}

void settle(const TableBasis& basis, const OpenModes& open, TableSolution& solution) {
  // The turn is held at the angle that it was turned to, so that is not taken out.
  MatrixXd combinations = open.combinations;
  combinations.col(kOpenTurn).setZero();
  const MatrixXd held = basis.modes * combinations;
  const MatrixXd functionals = combinations.transpose() * basis.functionals;
  const Eigen::RowVectorXd turned = turn_functional(basis);
  VectorXd turn = basis.modes * open.turn;
  turn /= turned * turn;
  const auto project = [&](auto& columns) {
    columns -= held * (functionals * columns).eval();
    columns -= turn * (turned * columns).eval();
  };
  project(solution.table_mm);
  project(solution.cov);
  solution.cov.transposeInPlace();
  project(solution.cov);
  solution.cov = 0.5 * (solution.cov + solution.cov.transpose().eval());
}

}  // namespace panelcal::internal
