// SPDX-License-Identifier: Apache-2.0
#include "calib/table/smoother.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/base/statistics/linear_algebra.h"

namespace panelcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Weights that are tried: from a part of the data's information on waves of the mean energy to a
/// multiple of that on the longest bent wave.
constexpr double kLeastWeight = 1e-12;
constexpr double kMostWeight = 1e6;
constexpr double kUsualWeight = 1e-4;
constexpr int kSearchSteps = 18;  ///< of golden sections: the logarithm to 0.01
/// Twice the logarithm of how many times as likely another process has to be.
constexpr double kClearlyLess = 2;
/// Singular values of the unbent part of the open modes, which are orthonormal or 0.
constexpr double kHeld = 1e-6;

/// M with the rows of each coordinate multiplied by U', x and y by turns.
MatrixXd of_waves(const MatrixXd& shapes, const MatrixXd& m) {
  MatrixXd out(2 * shapes.cols(), m.cols());
  for (Index c = 0; c < 2; ++c) {
    const MatrixXd rows = m(Eigen::seqN(c, shapes.rows(), Eigen::fix<2>), Eigen::all);
    out(Eigen::seqN(c, shapes.cols(), Eigen::fix<2>), Eigen::all) = shapes.transpose() * rows;
  }
  return out;
}

MatrixXd of_coefficients(const MatrixXd& shapes, const MatrixXd& m) {
  return of_waves(shapes.transpose(), m);
}

/// On a coefficient, in the mean.
double information_of(const TableSystem& system) {
  return system.normal().diagonal().mean();
}

}  // namespace

Smoother::Smoother(const TableWaves& waves,
                   const TableBasis& basis,
                   const TableSystem& system,
                   const OpenModes& open,
                   const VectorXd& before)
    : waves_(waves), energies_(waves.size()) {
  for (Index k = 0; k < waves.size(); ++k) energies_[k] = waves.energies[k / 2];
  const MatrixXd half = of_waves(waves.shapes, system.normal());
  normal_ = of_waves(waves.shapes, half.transpose());
  information_ = information_of(system);
  // Of modes of mean square 1 the functionals are short where the coefficients are many.
  const double hold = std::sqrt(information_ * static_cast<double>(basis.size()));
  const MatrixXd functionals = open.combinations.transpose() * basis.functionals;
  holds_ = hold * of_waves(waves.shapes, functionals.transpose()).transpose();
  held_normal_ = normal_ + holds_.transpose() * holds_;
  right_side_ = of_waves(waves.shapes, system.right_side()) +
                holds_.transpose() * (hold * (functionals * before));
  const MatrixXd unbent = holds_.leftCols(2 * TableWaves::kUnbent) / hold;
  const Eigensystem held = eigensystem(unbent.transpose() * unbent);
  const double most = held.values.tail(1).value();
  const Index n_held = (held.values.array() > kHeld * kHeld * most).count();
  held_ = held.vectors.rightCols(n_held);
}

MatrixXd Smoother::matrix(double weight) const {
  MatrixXd out = held_normal_;
  out.diagonal() += weight * energies_;
  return out;
}

/// By Sylvester's identity and Schur's complement over what is not bent, so that the small energies
/// of long waves are not lost beside the large ones of short waves:
///
///   |D + B'B| |N' (1 + B D^-1 B')^-1 N|,   |D + B'B| = |D| |1 + B D^-1 B'|
///
/// D is the energy of bent waves, and [N B] holds the open modes; N of the unbent ones that it
/// holds.
double Smoother::log_determinant_of_prior(double weight) const {
  const Index n_unbent = 2 * TableWaves::kUnbent;
  const Index n_bent = waves_.size() - n_unbent;
  const VectorXd energies = weight * energies_.tail(n_bent);
  const MatrixXd bent = holds_.rightCols(n_bent);
  const MatrixXd unbent = holds_.leftCols(n_unbent) * held_;
  MatrixXd of_holds = bent * energies.cwiseInverse().asDiagonal() * bent.transpose();
  of_holds.diagonal().array() += 1;
  const Cholesky held(of_holds);
  const Cholesky left(unbent.transpose() * held.solve(unbent));
  if (!held.is_definite() || !left.is_definite()) return std::numeric_limits<double>::quiet_NaN();
  return energies.array().log().sum() + held.log_determinant() + left.log_determinant();
}

double Smoother::badness(double weight) const {
  const Cholesky decomposed(matrix(weight));
  constexpr double kWorst = std::numeric_limits<double>::infinity();
  if (!decomposed.is_definite()) return kWorst;
  const double explained = right_side_.dot(decomposed.solve(right_side_));
  const double badness =
      decomposed.log_determinant() - log_determinant_of_prior(weight) - explained;
  return std::isfinite(badness) ? badness : kWorst;
}

std::optional<LikelyWeight> Smoother::best_weight() const {
  const auto badness_at = [&](double log_weight) { return badness(std::exp(log_weight)); };
  const double golden = (std::sqrt(5.0) - 1) / 2;
  double low = std::log(kLeastWeight * information_ / energies_.mean());
  double high = std::log(kMostWeight * information_ / energies_[2 * TableWaves::kUnbent]);
  double a = high - golden * (high - low);
  double b = low + golden * (high - low);
  double at_a = badness_at(a);
  double at_b = badness_at(b);
  for (int i = 0; i < kSearchSteps; ++i) {
    if (at_a < at_b) {
      high = b;
      b = a;
      at_b = at_a;
      a = high - golden * (high - low);
      at_a = badness_at(a);
    } else {
      low = a;
      a = b;
      at_a = at_b;
      b = low + golden * (high - low);
      at_b = badness_at(b);
    }
  }
  const double least = std::min(at_a, at_b);
  if (!std::isfinite(least)) return std::nullopt;
  return LikelyWeight{std::exp(at_a < at_b ? a : b), least};
}

std::optional<TableSolution> Smoother::solve(double weight) const {
  const Cholesky decomposed(matrix(weight));
  if (!decomposed.is_definite()) return std::nullopt;
  TableSolution out;
  out.smoothness = {waves_.process, waves_.length, weight};
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

double usual_weight(const TableSystem& system) {
  return kUsualWeight * information_of(system);
}

std::optional<LikelySmoothness> most_likely(std::span<const TableWaves> processes,
                                            const TableBasis& basis,
                                            const TableSystem& system,
                                            const OpenModes& open,
                                            const VectorXd& before) {
  std::optional<LikelySmoothness> best;
  double least = std::numeric_limits<double>::infinity();
  for (const TableWaves& waves : processes) {
    const Smoother smoother(waves, basis, system, open, before);
    const std::optional<LikelyWeight> found = smoother.best_weight();
    if (!found) continue;
    // All others are held against the first one by the same measure.
    const bool is_first = &waves == &processes.front();
    const double badness = found->badness - (is_first ? kClearlyLess : 0);
    if (best && badness >= least) continue;
    best = {&waves, found->weight};
    least = badness;
  }
  return best;
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
