// SPDX-License-Identifier: Apache-2.0
#include "calib/table/smoother.h"

#include <cmath>
#include <limits>

#include "calib/base/statistics/linear_algebra.h"

namespace panelcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Smoothings that are tried, in units of the one at which bending and data weigh the same.
constexpr double kLeastSmoothing = 1e-12;
constexpr double kMostSmoothing = 1e6;
constexpr int kSearchSteps = 24;  ///< of golden sections: the logarithm to 1e-3
/// Energy of a mode of mean square 1 that is not bent, but for rounding.
constexpr double kUnbentTable = 1e-6;

}  // namespace

Smoother::Smoother(const TableBasis& basis,
                   const TableSystem& system,
                   const OpenModes& open,
                   const VectorXd& before)
    : system_(system), functionals_(open.combinations.transpose() * basis.functionals) {
  const Index n = basis.grid.n_coefficients();
  bending_ = MatrixXd::Zero(2 * n, 2 * n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      bending_(2 * i, 2 * j) = bending_(2 * i + 1, 2 * j + 1) = basis.bending(i, j);
    }
  }
  const double information = system.normal().trace() / static_cast<double>(2 * n);
  unit_ = information / (bending_.trace() / static_cast<double>(2 * n));
  Index n_bent = 0;
  const MatrixXd held = basis.modes * open.combinations;
  for (Index k = 0; k < held.cols(); ++k) {
    n_bent += held.col(k).dot(bending_ * held.col(k)) > kUnbentTable;
  }
  rank_ = static_cast<double>(2 * (n - 3) - n_bent);
  // Of modes of mean square 1 the functionals are short where the coefficients are many.
  hold_ = information * static_cast<double>(2 * n);
  held_at_ = hold_ * (functionals_.transpose() * (functionals_ * before));
}

MatrixXd Smoother::matrix(double smoothing) const {
  return system_.normal() + smoothing * bending_ + hold_ * functionals_.transpose() * functionals_;
}

/// Minus twice the logarithm of the restricted likelihood, but for a constant.
double Smoother::badness(double log_smoothing) const {
  const double smoothing = std::exp(log_smoothing) * unit_;
  const Cholesky decomposed(matrix(smoothing));
  if (!decomposed.is_definite()) return std::numeric_limits<double>::infinity();
  const double explained = system_.right_side().dot(decomposed.solve(system_.right_side()));
  return decomposed.log_determinant() - rank_ * std::log(smoothing) - explained;
}

double Smoother::best() const {
  const double golden = (std::sqrt(5.0) - 1) / 2;
  double low = std::log(kLeastSmoothing);
  double high = std::log(kMostSmoothing);
  double a = high - golden * (high - low);
  double b = low + golden * (high - low);
  double at_a = badness(a);
  double at_b = badness(b);
  for (int i = 0; i < kSearchSteps; ++i) {
    if (at_a < at_b) {
      high = b;
      b = a;
      at_b = at_a;
      a = high - golden * (high - low);
      at_a = badness(a);
    } else {
      low = a;
      a = b;
      at_a = at_b;
      b = low + golden * (high - low);
      at_b = badness(b);
    }
  }
  return std::exp(0.5 * (low + high)) * unit_;
}

std::optional<TableSolution> Smoother::solve(double smoothing) const {
  const Cholesky decomposed(matrix(smoothing));
  if (!decomposed.is_definite()) return std::nullopt;
  TableSolution out;
  out.smoothing = smoothing;
  out.table_mm = decomposed.solve(VectorXd(system_.right_side() + held_at_));
  out.cov = decomposed.inverse();
  const MatrixXd share = out.cov * system_.normal();
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
