// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "calib/panel/model.h"
#include "calib/panel/target_pair.h"
#include <Eigen/Core>

// The work is done once per target on a square-root form: min |factor a - target|^2 over the six
// affine coefficients a. Each model then only searches its own parameters in six dimensions,
// whatever the number of targets. The square-root form loses half the digits a normal matrix would.
//
// A target gives two equations, J(p) a = measured, whitened by W with W^T W = cov^-1. A slot gives
// one of them: the other row is left out by a W whose row and column are zero. With that W the
// residual's part in chi square, the gain J^T W^T W and the covariance need no further care.
namespace panelcal::internal {

/// Program coordinates step by 0.1 um at best: targets nearer than this are one and the same.
inline constexpr double kCoincident_mm = 1e-6;
/// Least ratio of the targets' spreads across and along, below which they lie on one line.
inline constexpr double kCollinear = 1e-6;
/// Correlation of a measurement's x and y errors so near to 1 that its covariance is no ellipse.
inline constexpr double kSingularCovariance = 1e-12;
/// Standard deviations outside this range are no measurement's; inside it no square overflows.
inline constexpr double kLeastSigma_mm = 1e-12;
inline constexpr double kGreatestSigma_mm = 1e12;

/// Where the targets lie; fits are done in (p - center) / scale.
struct Spread {
  Eigen::Vector2d from_center_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_center_mm = Eigen::Vector2d::Zero();  ///< of what is observed, by coordinate
  double along_mm = 0;   ///< r.m.s. distance from the centre along the longest direction
  double across_mm = 0;  ///< and across it
  double scale_mm() const { return along_mm > kCoincident_mm ? along_mm : 1.0; }
};

struct SquareRoot {
  Eigen::Matrix<double, 6, 7> rows = Eigen::Matrix<double, 6, 7>::Zero();
  auto factor() const { return rows.leftCols<6>(); }
  auto target() const { return rows.col(6); }
  double cost(const Coefficients& a) const { return (factor() * a - target()).squaredNorm(); }
};

/// v, with 0 for a coordinate that is not observed, whatever stands there.
inline Eigen::Vector2d observed_part(const Eigen::Vector2d& v, ObservedAxes axes) {
  return {observes_x(axes) ? v.x() : 0.0, observes_y(axes) ? v.y() : 0.0};
}

inline int equation_count(std::span<const RawPair> pairs) {
  int n = 0;
  for (const RawPair& pair : pairs) n += pair.axes == ObservedAxes::Both ? 2 : 1;
  return n;
}

inline bool has_slots(std::span<const RawPair> pairs) {
  return std::ranges::any_of(pairs,
                             [](const RawPair& pair) { return pair.axes != ObservedAxes::Both; });
}

inline Eigen::Vector2d observed_center(std::span<const RawPair> pairs) {
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

inline Spread spread_of(std::span<const RawPair> pairs) {
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

/// Where the target was seen from the centre; 0 where it was not.
inline Eigen::Vector2d seen_from_center(const RawPair& pair, const Spread& spread) {
  return observed_part(pair.to_mm - spread.to_center_mm, pair.axes);
}

inline bool is_sigma(double sigma_mm) {
  return sigma_mm >= kLeastSigma_mm && sigma_mm <= kGreatestSigma_mm;
}

/// W with W^T W = cov^-1, lower triangular; empty if cov is no covariance.
inline std::optional<Eigen::Matrix2d> whitening(const Eigen::Matrix2d& cov) {
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

/// The same for what a target shows: of a slot only the variance along its axis counts.
inline std::optional<Eigen::Matrix2d> whitening(const RawPair& pair) {
  if (pair.axes == ObservedAxes::Both) return whitening(pair.cov_mm2);
  const int axis = pair.axes == ObservedAxes::X ? 0 : 1;
  const double sigma_mm = std::sqrt(pair.cov_mm2(axis, axis));
  if (!is_sigma(sigma_mm)) return std::nullopt;
  Eigen::Matrix2d w = Eigen::Matrix2d::Zero();
  w(axis, axis) = 1 / sigma_mm;
  return w;
}

/// The two rows d(point) / d(coefficients) of a target.
inline Eigen::Matrix<double, 2, 6> design(const Eigen::Vector2d& from) {
  Eigen::Matrix<double, 2, 6> d;
  d << from.x(), from.y(), 0, 0, 1, 0, 0, 0, from.x(), from.y(), 0, 1;
  return d;
}

/// Rotates one more equation into the triangular factor (Givens).
inline void absorb(SquareRoot& system, Eigen::Matrix<double, 1, 7> row) {
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

/// Empty if a covariance is bad or a number is not finite.
inline std::optional<SquareRoot> accumulate(std::span<const RawPair> pairs, const Spread& spread) {
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

/// The equations as geometry alone: every one of the same weight, nothing measured.
inline SquareRoot structure_of(std::span<const RawPair> pairs, const Spread& spread) {
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
