// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "calib/faults/constellation_target.h"
#include "calib/panel/gates.h"
#include <Eigen/Core>

// Not installed.
namespace panelcal::internal {

/// Place of a target by a map, with its uncertainty: the residual of healthy panels included.
struct Prediction {
  Eigen::Vector2d place_mm;
  Eigen::Matrix2d cov_mm2;

  /// Squared distance of a measured place, in sigmas of both.
  double distance2(const Eigen::Vector2d& measured_mm, const Eigen::Matrix2d& measured_mm2) const;
};

/// The panel's map while targets are assigned one after the other: a normal belief of
///
///   place = expected + t + (theta J + e I + d diag(1, -1) + k [0 1; 0 0]) (expected - center)
///
/// updated by each target (Kalman 1960). The square of a rotation counts as scale. The sum of the
/// innovations' squared distances is the minimum of the joint cost.
class ConstellationMap {
 public:
  /// The belief before any target: t open, the rest as the limits say.
  ConstellationMap(std::span<const ConstellationTarget> targets, const GateLimits& limits);

  Prediction predicted(const Eigen::Vector2d& expected_mm) const;
  ConstellationMap with(const Eigen::Vector2d& expected_mm,
                        const Eigen::Vector2d& measured_mm,
                        const Eigen::Matrix2d& measured_mm2) const;
  double rotation_rad() const { return mean_[2]; }

 private:
  using Design = Eigen::Matrix<double, 2, 6>;
  Design design(const Eigen::Vector2d& expected_mm) const;

  Eigen::Vector2d center_mm_ = Eigen::Vector2d::Zero();
  double tolerance_mm2_ = 0;
  Eigen::Matrix<double, 6, 1> mean_ = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 6> cov_ = Eigen::Matrix<double, 6, 6>::Zero();
};

}  // namespace panelcal::internal
