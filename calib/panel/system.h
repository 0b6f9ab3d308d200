// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
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

/// Centre and scale of the targets' places; fits are done in (p - center) / scale.
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
  double cost(const Coefficients& a) const;
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

Spread spread_of(std::span<const RawPair> pairs);

/// Measured place of the target from the centre; 0 along an axis that was not measured.
inline Eigen::Vector2d seen_from_center(const RawPair& pair, const Spread& spread) {
  return observed_part(pair.to_mm - spread.to_center_mm, pair.axes);
}

/// W with W^T W = cov^-1, lower triangular; empty if cov is no covariance.
std::optional<Eigen::Matrix2d> whitening(const Eigen::Matrix2d& cov);

/// The same for what a target shows: of a slot only the variance along its axis counts.
std::optional<Eigen::Matrix2d> whitening(const RawPair& pair);

/// The two rows d(point) / d(coefficients) of a target.
inline Eigen::Matrix<double, 2, 6> design(const Eigen::Vector2d& from) {
  Eigen::Matrix<double, 2, 6> d;
  d << from.x(), from.y(), 0, 0, 1, 0, 0, 0, from.x(), from.y(), 0, 1;
  return d;
}

/// Empty if a covariance is bad or a number is not finite.
std::optional<SquareRoot> accumulate(std::span<const RawPair> pairs, const Spread& spread);

/// The equations as geometry alone: every one of the same weight, nothing measured.
SquareRoot structure_of(std::span<const RawPair> pairs, const Spread& spread);

}  // namespace panelcal::internal
