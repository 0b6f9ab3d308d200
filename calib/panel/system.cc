// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/system.h"

#include <algorithm>
#include <cmath>

namespace panelcal::internal {
namespace {

Eigen::Vector2d observed_center(std::span<const RawPair> pairs) {
  Eigen::Vector2d sum_mm = Eigen::Vector2d::Zero();
  int n_x = 0;
  int n_y = 0;
  for (const RawPair& pair : pairs) {
    sum_mm += observed_part(pair.to_mm, pair.axes);
    if (observes_x(pair.axes)) ++n_x;
    if (observes_y(pair.axes)) ++n_y;
  }
  return {sum_mm.x() / std::max(1, n_x), sum_mm.y() / std::max(1, n_y)};
}

bool is_sigma(double sigma_mm) {
  return sigma_mm >= kLeastSigma_mm && sigma_mm <= kGreatestSigma_mm;
}

/// Rotates one more equation into the triangular factor (Givens).
void absorb(SquareRoot& system, Eigen::Matrix<double, 1, 7> row) {
  for (int k = 0; k < 6; ++k) {
    if (row[k] == 0) continue;
    const double pivot = system.rows(k, k);
    const double length = std::sqrt(pivot * pivot + row[k] * row[k]);
    const double c = pivot / length;
    const double s = row[k] / length;
    for (int j = k; j < 7; ++j) {
      const double upper = system.rows(k, j);
      system.rows(k, j) = c * upper + s * row[j];
      row[j] = c * row[j] - s * upper;
    }
  }
}

}  // namespace

double SquareRoot::cost(const Coefficients& a) const {
  return (factor() * a - target()).squaredNorm();
}

Spread spread_of(std::span<const RawPair> pairs) {
  Spread s;
  for (const RawPair& pair : pairs) s.from_center_mm += pair.from_mm;
  const auto n = static_cast<double>(pairs.size());
  s.from_center_mm /= n;
  s.to_center_mm = observed_center(pairs);
  double xx = 0, xy = 0, yy = 0;
  for (const RawPair& pair : pairs) {
    const Eigen::Vector2d d = pair.from_mm - s.from_center_mm;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    yy += d.y() * d.y();
  }
  const double half_trace = 0.5 * (xx + yy);
  const double largest = half_trace + std::hypot(0.5 * (xx - yy), xy);
  s.along_mm = std::sqrt(largest / n);
  const double determinant = std::max(0.0, xx * yy - xy * xy);
  s.across_mm = largest > 0 ? std::sqrt(determinant / largest / n) : 0;
  return s;
}

std::optional<Eigen::Matrix2d> whitening(const Eigen::Matrix2d& cov) {
  const double xx = cov(0, 0);
  const double yy = cov(1, 1);
  const double xy = 0.5 * (cov(0, 1) + cov(1, 0));
  if (!cov.allFinite() || !(xx > 0) || !(yy > 0)) return std::nullopt;
  if (std::abs(cov(0, 1) - cov(1, 0)) > 1e-9 * std::sqrt(xx) * std::sqrt(yy)) return std::nullopt;
  const double sigma_x = std::sqrt(xx);
  const double slope = xy / xx;
  const double rest = yy - slope * xy;
  if (!(rest > kSingularCovariance * yy)) return std::nullopt;
  const double sigma_rest = std::sqrt(rest);
  if (!is_sigma(sigma_x) || !is_sigma(sigma_rest)) return std::nullopt;
  Eigen::Matrix2d w;
  w << 1 / sigma_x, 0, -slope / sigma_rest, 1 / sigma_rest;
  return w;
}

std::optional<Eigen::Matrix2d> whitening(const RawPair& pair) {
  if (pair.axes == ObservedAxes::Both) return whitening(pair.cov_mm2);
  const int axis = pair.axes == ObservedAxes::X ? 0 : 1;
  const double sigma_mm = std::sqrt(pair.cov_mm2(axis, axis));
  if (!is_sigma(sigma_mm)) return std::nullopt;
  Eigen::Matrix2d w = Eigen::Matrix2d::Zero();
  w(axis, axis) = 1 / sigma_mm;
  return w;
}

std::optional<SquareRoot> accumulate(std::span<const RawPair> pairs, const Spread& spread) {
  SquareRoot system;
  for (const RawPair& pair : pairs) {
    const std::optional<Eigen::Matrix2d> w = whitening(pair);
    if (!w) return std::nullopt;
    Eigen::Matrix<double, 2, 7> rows;
    rows << design((pair.from_mm - spread.from_center_mm) / spread.scale_mm()),
        seen_from_center(pair, spread) / spread.scale_mm();
    const Eigen::Matrix<double, 2, 7> white = spread.scale_mm() * *w * rows;
    absorb(system, white.row(0));
    absorb(system, white.row(1));
  }
  if (!system.rows.allFinite()) return std::nullopt;
  return system;
}

SquareRoot structure_of(std::span<const RawPair> pairs, const Spread& spread) {
  SquareRoot structure;
  for (const RawPair& pair : pairs) {
    Eigen::Matrix<double, 2, 7> rows = Eigen::Matrix<double, 2, 7>::Zero();
    rows.leftCols<6>() = design((pair.from_mm - spread.from_center_mm) / spread.scale_mm());
    if (observes_x(pair.axes)) absorb(structure, rows.row(0));
    if (observes_y(pair.axes)) absorb(structure, rows.row(1));
  }
  return structure;
}

}  // namespace panelcal::internal
