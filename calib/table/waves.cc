// SPDX-License-Identifier: Apache-2.0
#include "calib/table/waves.h"

#include <array>
#include <cmath>

#include "calib/base/statistics/linear_algebra.h"

namespace panelcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::array kLengths = {0.1, 0.2, 0.4, 0.8, 1.6};
/// Variances that are rounding beside the largest.
constexpr double kRoundingOfVariances = 1e-10;

/// Matern's, 5/2. In lengths of the process.
double correlation(double distance) {
  const double scaled = std::sqrt(5.0) * distance;
  return (1 + scaled + scaled * scaled / 3) * std::exp(-scaled);
}

}  // namespace

TableWaves plate_waves(const TableBasis& basis) {
  const Eigensystem bending = eigensystem(basis.bending);
  TableWaves waves;
  waves.shapes = bending.vectors;
  waves.energies = bending.values / bending.values.mean();
  waves.energies.head(TableWaves::kUnbent).setZero();
  return waves;
}

TableWaves matern_waves(const TableBasis& basis, double length) {
  constexpr Index kUnbent = TableWaves::kUnbent;
  const Index n = basis.grid.n_coefficients();
  const Index n_columns = basis.grid.nx + 3;
  MatrixXd linear(n, kUnbent);
  MatrixXd cov(n, n);
  const auto place = [&](Index i) {
    return Eigen::Vector2d(static_cast<double>(i % n_columns), static_cast<double>(i / n_columns));
  };
  const Eigen::Vector2d side_mm = basis.grid.high_mm - basis.grid.low_mm;
  const Eigen::Vector2d step_in_lengths =
      side_mm.cwiseQuotient(Eigen::Vector2d(basis.grid.nx, basis.grid.ny)) /
      (length * side_mm.maxCoeff());
  for (Index i = 0; i < n; ++i) {
    linear.row(i) << 1, place(i).transpose();
    for (Index j = 0; j <= i; ++j) {
      const double distance = step_in_lengths.cwiseProduct(place(i) - place(j)).norm();
      cov(i, j) = cov(j, i) = correlation(distance);
    }
  }
  const OrthogonalTriangular parts(linear);
  const MatrixXd q = parts.q();
  const Eigensystem bent =
      eigensystem(parts.turned(cov).bottomRightCorner(n - kUnbent, n - kUnbent));
  const double most = bent.values.tail(1).value();
  const Index n_kept = (bent.values.array() > kRoundingOfVariances * most).count();
  TableWaves waves{
      TableProcess::Matern, length, MatrixXd(n, kUnbent + n_kept), VectorXd(kUnbent + n_kept)};
  waves.shapes << q.leftCols(kUnbent),
      (q.rightCols(n - kUnbent) * bent.vectors.rightCols(n_kept)).rowwise().reverse();
  waves.energies << VectorXd::Zero(kUnbent),
      most * bent.values.tail(n_kept).reverse().cwiseInverse();
  return waves;
}

std::vector<TableWaves> all_waves(const TableBasis& basis) {
  std::vector<TableWaves> all = {plate_waves(basis)};
  for (const double length : kLengths) all.push_back(matern_waves(basis, length));
  return all;
}

}  // namespace panelcal::internal
