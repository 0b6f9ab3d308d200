// SPDX-License-Identifier: Apache-2.0
#include "calib/table/smoother.h"

#include <algorithm>
#include <array>
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
constexpr int kSearchSteps = 16;  ///< of golden sections: the logarithm to 0.02
constexpr double kUsualSmoothing = 1e-4;
/// Energy of a mode of mean square 1 that is not bent, but for rounding.
constexpr double kUnbentTable = 1e-6;
constexpr Index kUnbentModes = 3;  ///< of a coordinate: what is linear in the place
/// A thin plate's, and those of smoother surfaces. Four times as steep is as good as no short wave.
constexpr std::array kOrders = {1.0, 1.5, 2.0, 3.0};

}  // namespace

Smoother::Smoother(const TableBasis& basis,
                   const TableSystem& system,
                   const OpenModes& open,
                   const VectorXd& before)
    : system_(system), functionals_(open.combinations.transpose() * basis.functionals) {
  const Index n = basis.grid.n_coefficients();
  information_ = system.normal().trace() / static_cast<double>(2 * n);
  // Of modes of mean square 1 the functionals are short where the coefficients are many.
  hold_ = information_ * static_cast<double>(2 * n);
  held_at_ = hold_ * (functionals_.transpose() * (functionals_ * before));
  for (const double order : kOrders) energies_.push_back(energy_of(basis, order));
  Index n_bent = 0;
  const MatrixXd held = basis.modes * open.combinations;
  for (Index k = 0; k < held.cols(); ++k) {
    n_bent += held.col(k).dot(energies_.front().matrix * held.col(k)) > kUnbentTable;
  }
  rank_ = static_cast<double>(2 * (n - kUnbentModes) - n_bent);
}

Smoother::Energy Smoother::energy_of(const TableBasis& basis, double order) const {
  const Index n = basis.grid.n_coefficients();
  const Eigensystem waves = eigensystem(basis.bending);
  VectorXd powers = (waves.values / waves.values.mean()).cwiseMax(0).array().pow(order);
  powers.head(kUnbentModes).setZero();
  const MatrixXd of_one = waves.vectors * powers.asDiagonal() * waves.vectors.transpose();
  Energy energy;
  energy.order = order;
  energy.matrix = MatrixXd::Zero(2 * n, 2 * n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      energy.matrix(2 * i, 2 * j) = energy.matrix(2 * i + 1, 2 * j + 1) = of_one(i, j);
    }
  }
  energy.unit = information_ / powers.mean();
  // What is neither bent nor determined is held, in every order alike.
  MatrixXd whole = energy.matrix + hold_ / information_ * functionals_.transpose() * functionals_;
  const MatrixXd unbent = waves.vectors.leftCols(kUnbentModes);
  const MatrixXd of_unbent = unbent * unbent.transpose();
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      whole(2 * i, 2 * j) += of_unbent(i, j);
      whole(2 * i + 1, 2 * j + 1) += of_unbent(i, j);
    }
  }
  energy.log_determinant = Cholesky(whole).log_determinant();
  return energy;
}

MatrixXd Smoother::matrix(const Energy& energy, double weight) const {
  return system_.normal() + weight * energy.matrix +
         hold_ * functionals_.transpose() * functionals_;
}

/// Minus twice the logarithm of the restricted likelihood, but for a constant.
double Smoother::badness(const Energy& energy, double log_weight) const {
  const double weight = std::exp(log_weight) * energy.unit;
  const Cholesky decomposed(matrix(energy, weight));
  if (!decomposed.is_definite()) return std::numeric_limits<double>::infinity();
  const double explained = system_.right_side().dot(decomposed.solve(system_.right_side()));
  return decomposed.log_determinant() - rank_ * std::log(weight) - energy.log_determinant -
         explained;
}

Smoother::Found Smoother::best_of(const Energy& energy) const {
  const double golden = (std::sqrt(5.0) - 1) / 2;
  double low = std::log(kLeastSmoothing);
  double high = std::log(kMostSmoothing);
  double a = high - golden * (high - low);
  double b = low + golden * (high - low);
  double at_a = badness(energy, a);
  double at_b = badness(energy, b);
  for (int i = 0; i < kSearchSteps; ++i) {
    if (at_a < at_b) {
      high = b;
      b = a;
      at_b = at_a;
      a = high - golden * (high - low);
      at_a = badness(energy, a);
    } else {
      low = a;
      a = b;
      at_a = at_b;
      b = low + golden * (high - low);
      at_b = badness(energy, b);
    }
  }
  return {{energy.order, std::exp(0.5 * (low + high)) * energy.unit}, std::min(at_a, at_b)};
}

TableSmoothness Smoother::usual() const {
  const Energy& energy = energies_.front();
  return {energy.order, kUsualSmoothing * energy.unit};
}

TableSmoothness Smoother::best(bool over_orders) const {
  Found best = best_of(energies_.front());
  if (!over_orders) return best.smoothness;
  for (std::size_t k = 1; k < energies_.size(); ++k) {
    const Found found = best_of(energies_[k]);
    if (found.badness < best.badness) best = found;
  }
  return best.smoothness;
}

std::optional<TableSolution> Smoother::solve(const TableSmoothness& smoothness) const {
  const auto energy = std::ranges::find(energies_, smoothness.order, &Energy::order);
  if (energy == energies_.end()) return std::nullopt;
  const Cholesky decomposed(matrix(*energy, smoothness.weight));
  if (!decomposed.is_definite()) return std::nullopt;
  TableSolution out;
  out.smoothness = smoothness;
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
