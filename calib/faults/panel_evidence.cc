// SPDX-License-Identifier: Apache-2.0
#include "calib/faults/panel_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "calib/panel/system.h"
#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

constexpr int kMaxEvidenceIterations = 20;
/// Wide enough for panels that are laid by hand, where the machine's file sets no limit.
constexpr double kWideOffset_mm = 10;
constexpr double kWideRotation_rad = 0.02;
constexpr double kWideStretch = 2e-3;
/// A limit of nothing still leaves a prior.
constexpr double kLeast = 1e-9;

/// [tx, ty, theta, e, d, k] in units of what is believed.
using Parameters = Eigen::Matrix<double, 6, 1>;
using Normal = Eigen::Matrix<double, 6, 6>;

Parameters scales_of(const PanelBelief& b) {
  Parameters out;
  out << b.offset_mm, b.offset_mm, b.rotation_rad, b.scale, b.difference, b.shear;
  return out;
}

/// R(theta) [1 + e + d, k; 0, 1 + e - d], and its derivatives by theta, e, d and k.
struct Deformation {
  Eigen::Matrix2d value;
  Eigen::Matrix2d by[4];
};

Deformation deformation(double theta_rad, double e, double d, double k) {
  Eigen::Matrix2d r, quarter, u, unit, opposite, shear;
  r << std::cos(theta_rad), -std::sin(theta_rad), std::sin(theta_rad), std::cos(theta_rad);
  quarter << 0, -1, 1, 0;
  u << 1 + e + d, k, 0, 1 + e - d;
  opposite << 1, 0, 0, -1;
  shear << 0, 1, 0, 0;
  unit.setIdentity();
  return {r * u, {r * quarter * u, r * unit, r * opposite, r * shear}};
}

/// The inverse of a target's covariance, 0 for what it does not show.
Eigen::Matrix2d weight_of(const ToldTarget& target) {
  if (target.axes == ObservedAxes::Both) return target.cov_mm2.inverse();
  Eigen::Matrix2d weight = Eigen::Matrix2d::Zero();
  const int axis = target.axes == ObservedAxes::X ? 0 : 1;
  weight(axis, axis) = 1 / target.cov_mm2(axis, axis);
  return weight;
}

double log_norm_of(const ToldTarget& target) {
  const double two_pi = 2 * std::numbers::pi;
  if (target.axes == ObservedAxes::Both) {
    return -0.5 * std::log(two_pi * two_pi * target.cov_mm2.determinant());
  }
  const int axis = target.axes == ObservedAxes::X ? 0 : 1;
  return -0.5 * std::log(two_pi * target.cov_mm2(axis, axis));
}

class Story {
 public:
  Story(std::span<const ToldTarget> targets, const PanelBelief& belief, const Lie& lie)
      : targets_(targets), scales_(scales_of(belief)), lie_(lie) {
    for (const ToldTarget& target : targets) center_mm_ += target.from_mm;
    center_mm_ /= static_cast<double>(targets.size());
    laid_center_mm_ = lie.turn * center_mm_ + lie.shift_mm;
  }

  Eigen::Matrix2d linear(const Parameters& z) const { return at(z).value * lie_.turn; }
  Eigen::Vector2d translation_mm(const Parameters& z) const {
    return laid_center_mm_ + shift_mm(z) - linear(z) * center_mm_;
  }

  double cost(const Parameters& z) const {
    const Eigen::Matrix2d l = linear(z);
    const Eigen::Vector2d t_mm = translation_mm(z);
    double sum = z.squaredNorm();
    for (const ToldTarget& target : targets_) {
      const Eigen::Vector2d r_mm =
          observed_part(target.to_mm - l * target.from_mm - t_mm, target.axes);
      sum += r_mm.dot(weight_of(target) * r_mm);
    }
    return sum;
  }

  /// Minus half the gradient of the cost, and half its Gauss-Newton curvature.
  void linearise(const Parameters& z, Parameters& descent, Normal& curvature) const {
    const Deformation deformed = at(z);
    curvature.setIdentity();
    descent = -z;
    for (const ToldTarget& target : targets_) {
      const Eigen::Vector2d arm_mm = lie_.turn * (target.from_mm - center_mm_);
      Eigen::Matrix<double, 2, 6> j;
      j.leftCols<2>().setIdentity();
      for (int k = 0; k < 4; ++k) j.col(2 + k) = deformed.by[k] * arm_mm;
      j = j * scales_.asDiagonal();
      const Eigen::Vector2d r_mm = observed_part(
          target.to_mm - laid_center_mm_ - shift_mm(z) - deformed.value * arm_mm, target.axes);
      const Eigen::Matrix2d weight = weight_of(target);
      curvature += j.transpose() * weight * j;
      descent += j.transpose() * (weight * r_mm);
    }
  }

 private:
  Deformation at(const Parameters& z) const {
    return deformation(scales_[2] * z[2], scales_[3] * z[3], scales_[4] * z[4], scales_[5] * z[5]);
  }
  Eigen::Vector2d shift_mm(const Parameters& z) const {
    return {scales_[0] * z[0], scales_[1] * z[1]};
  }

  std::span<const ToldTarget> targets_;
  Parameters scales_;
  Lie lie_;
  Eigen::Vector2d center_mm_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d laid_center_mm_ = Eigen::Vector2d::Zero();
};

}  // namespace

PanelBelief belief_of(const GateLimits& limits, PanelModel model) {
  PanelBelief belief;
  belief.offset_mm = std::max(kLeast, limits.offset ? limits.offset->in_mm() / 2 : kWideOffset_mm);
  if (model == PanelModel::Offset) return belief;
  belief.rotation_rad =
      std::max(kLeast, limits.rotation ? limits.rotation->in_rad() / 2 : kWideRotation_rad);
  if (model == PanelModel::Rigid) return belief;
  const double stretch =
      std::max(kLeast, limits.stretch_ppm ? *limits.stretch_ppm * 1e-6 / 2 : kWideStretch);
  belief.scale = stretch;
  if (model == PanelModel::Similarity) return belief;
  // Mean and half the difference of two independent scales.
  belief.scale = belief.difference = stretch / std::numbers::sqrt2;
  if (model == PanelModel::Affine) belief.shear = stretch;
  return belief;
}

Evidence evidence(std::span<const ToldTarget> targets, const PanelBelief& belief, const Lie& lie) {
  const Story story(targets, belief, lie);
  Parameters z = Parameters::Zero();
  Parameters descent;
  Normal curvature;
  double cost = story.cost(z);
  for (int i = 0; i < kMaxEvidenceIterations; ++i) {
    story.linearise(z, descent, curvature);
    Parameters step = curvature.ldlt().solve(descent);
    double next = story.cost(z + step);
    for (int k = 0; k < 20 && !(next <= cost * (1 + 1e-12) + 1e-9); ++k) {
      step *= 0.5;
      next = story.cost(z + step);
    }
    z += step;
    const bool is_done = !(std::abs(cost - next) > 1e-6);
    cost = next;
    if (is_done) break;
  }
  story.linearise(z, descent, curvature);
  Evidence out;
  out.linear = story.linear(z);
  out.translation_mm = story.translation_mm(z);
  out.log_likelihood = -0.5 * cost;
  for (const ToldTarget& target : targets) out.log_likelihood += log_norm_of(target);
  const Parameters pivots = curvature.ldlt().vectorD();
  for (int k = 0; k < 6; ++k) out.log_likelihood -= 0.5 * std::log(std::max(pivots[k], 1.0));
  if (!std::isfinite(out.log_likelihood)) {
    out.log_likelihood = -std::numeric_limits<double>::infinity();
  }
  return out;
}

}  // namespace panelcal::internal
