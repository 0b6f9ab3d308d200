// SPDX-License-Identifier: Apache-2.0
#include "calib/faults/constellation_map.h"

#include <algorithm>
#include <cmath>

#include "calib/faults/panel_evidence.h"
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

/// So wide that it pulls at no shift.
constexpr double kOpenShift_mm = 1e3;
/// Residual of healthy panels where [gates] residual_um does not limit it, one sigma.
constexpr double kUsualResidual_mm = 0.05;

}  // namespace

double Prediction::distance2(const Eigen::Vector2d& measured_mm,
                             const Eigen::Matrix2d& measured_mm2) const {
  const Eigen::Vector2d off_mm = measured_mm - place_mm;
  return off_mm.dot((cov_mm2 + measured_mm2).inverse() * off_mm);
}

ConstellationMap::ConstellationMap(std::span<const ConstellationTarget> targets,
                                   const GateLimits& limits) {
  for (const ConstellationTarget& target : targets) {
    center_mm_ += target.expected_mm / static_cast<double>(targets.size());
  }
  // A limit is two sigma, as in PanelBelief.
  const double residual_mm = limits.residual ? limits.residual->in_mm() / 2 : kUsualResidual_mm;
  tolerance_mm2_ = residual_mm * residual_mm;
  const PanelBelief belief = belief_of(limits, PanelModel::Affine);
  const double bow = 2 * belief.rotation_rad * belief.rotation_rad;  // 1 - cos at the limit
  cov_.diagonal() << kOpenShift_mm * kOpenShift_mm, kOpenShift_mm * kOpenShift_mm,
      belief.rotation_rad * belief.rotation_rad, belief.scale * belief.scale + bow * bow,
      belief.difference * belief.difference, belief.shear * belief.shear;
}

ConstellationMap::Design ConstellationMap::design(const Eigen::Vector2d& expected_mm) const {
  const Eigen::Vector2d arm_mm = expected_mm - center_mm_;
  Design out;
  out << 1, 0, -arm_mm.y(), arm_mm.x(), arm_mm.x(), arm_mm.y(),  //
      0, 1, arm_mm.x(), arm_mm.y(), -arm_mm.y(), 0;
  return out;
}

Prediction ConstellationMap::predicted(const Eigen::Vector2d& expected_mm) const {
  const Design h = design(expected_mm);
  return {expected_mm + h * mean_,
          h * cov_ * h.transpose() + tolerance_mm2_ * Eigen::Matrix2d::Identity()};
}

ConstellationMap ConstellationMap::with(const Eigen::Vector2d& expected_mm,
                                        const Eigen::Vector2d& measured_mm,
                                        const Eigen::Matrix2d& measured_mm2) const {
  const Design h = design(expected_mm);
  const Prediction at = predicted(expected_mm);
  const Eigen::Matrix2d innovation_mm2 = at.cov_mm2 + measured_mm2;
  const Eigen::Matrix<double, 6, 2> gain = cov_ * h.transpose() * innovation_mm2.inverse();
  ConstellationMap out = *this;
  out.mean_ += gain * (measured_mm - at.place_mm);
  // Joseph's form stays positive whatever rounds.
  const Eigen::Matrix<double, 6, 6> rest = Eigen::Matrix<double, 6, 6>::Identity() - gain * h;
  const Eigen::Matrix2d noise_mm2 = innovation_mm2 - h * cov_ * h.transpose();
  out.cov_ = rest * cov_ * rest.transpose() + gain * noise_mm2 * gain.transpose();
  return out;
}

}  // namespace panelcal::internal
