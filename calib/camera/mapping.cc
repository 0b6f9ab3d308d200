// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/mapping.h"

#include <cmath>

namespace panelcal {
namespace {

/// Newton's method on r (1 + k1 r^2) = bent converges from one side without overshooting, since
/// the left side has no turning point between the start and the root; near a fold it halves the
/// error per step.
constexpr int kMaxMappingIterations = 100;

/// The radius that the lens model carries to `bent_px`; empty from the fold on.
std::optional<double> straight_radius_px(double bent_px, double k1_per_px2) {
  if (k1_per_px2 < 0) {
    const double fold_px = 1 / std::sqrt(-3 * k1_per_px2);
    if (!(bent_px < fold_px * 2 / 3)) return std::nullopt;
  }
  double r_px = bent_px;
  for (int i = 0; i < kMaxMappingIterations; ++i) {
    const double slope = 1 + 3 * k1_per_px2 * r_px * r_px;
    if (!(slope > 0)) return std::nullopt;
    const double step_px = (r_px * (1 + k1_per_px2 * r_px * r_px) - bent_px) / slope;
    r_px -= step_px;
    if (!(std::abs(step_px) > 1e-15 * r_px)) break;
  }
  return r_px;
}

}  // namespace

CameraMapping::CameraMapping(const Parameters& parameters) : parameters_(parameters) {
  const double c = parameters.scale_mm_per_px * std::cos(parameters.rotation_rad);
  const double s = parameters.scale_mm_per_px * std::sin(parameters.rotation_rad);
  mm_from_px_ << c, s, s, -c;
}

Position<frame::Optical> CameraMapping::operator()(const Position<frame::Image>& u) const {
  const Eigen::Vector2d d_px = u.in_px() - parameters_.axis_px;
  const double bend = 1 + parameters_.k1_per_px2 * d_px.squaredNorm();
  return position_mm<frame::Optical>(mm_from_px_ * d_px * bend);
}

Eigen::Matrix2d CameraMapping::jacobian(const Position<frame::Image>& u) const {
  const Eigen::Vector2d d_px = u.in_px() - parameters_.axis_px;
  const double bend = 1 + parameters_.k1_per_px2 * d_px.squaredNorm();
  const Eigen::Matrix2d bent_by_d =
      bend * Eigen::Matrix2d::Identity() + 2 * parameters_.k1_per_px2 * d_px * d_px.transpose();
  return mm_from_px_ * bent_by_d;
}

PositionEstimate<frame::Optical> CameraMapping::operator()(
    const PositionEstimate<frame::Image>& u) const {
  return {(*this)(u.position), propagate(jacobian(u.position), u.cov)};
}

CameraJacobian CameraMapping::by_parameters(const Position<frame::Image>& u) const {
  const Eigen::Vector2d d_px = u.in_px() - parameters_.axis_px;
  const Eigen::Vector2d seen_mm = (*this)(u).in_mm();
  CameraJacobian j;
  j.col(0) = seen_mm / parameters_.scale_mm_per_px;
  j.col(1) << -seen_mm.y(), seen_mm.x();
  j.middleCols<2>(2) = -jacobian(u);
  j.col(4) = mm_from_px_ * d_px * d_px.squaredNorm();
  return j;
}

std::optional<Position<frame::Image>> CameraMapping::image_of(
    const Position<frame::Optical>& p) const {
  if (!p.in_mm().allFinite()) return std::nullopt;
  const double scale = parameters_.scale_mm_per_px;
  // The linear part is scale times a reflection, which is its own inverse.
  const Eigen::Vector2d bent_px = mm_from_px_ * p.in_mm() / (scale * scale);
  const double length_px = bent_px.norm();
  if (length_px == 0) return position_px<frame::Image>(parameters_.axis_px);
  const std::optional<double> r_px = straight_radius_px(length_px, parameters_.k1_per_px2);
  if (!r_px) return std::nullopt;
  const Eigen::Vector2d u_px = parameters_.axis_px + bent_px * (*r_px / length_px);
  return position_px<frame::Image>(u_px);
}

}  // namespace panelcal
