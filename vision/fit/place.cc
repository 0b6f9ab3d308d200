// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/place.h"

#include <cmath>

#include <Eigen/LU>

namespace panelcal::internal {

PositionEstimate<frame::Image> in_image(const FitFrame& fit_frame,
                                        const Eigen::Vector2d& at,
                                        const Eigen::Matrix2d& cov) {
  const Eigen::Vector2d u = fit_frame.to_image(at).value_or(Eigen::Vector2d::Zero());
  const Eigen::Matrix2d px_from_frame = fit_frame.jacobian(u).inverse();
  return {position_px<frame::Image>(u), propagate(px_from_frame, cov)};
}

void set_place(const FitFrame& fit_frame,
               const Eigen::Vector2d& at,
               const Eigen::Matrix2d& cov,
               double size,
               TargetFit& fit) {
  fit.center = in_image(fit_frame, at, cov);
  const Eigen::Matrix2d frame_from_px = fit_frame.jacobian(fit.center.position.in_px());
  fit.size = px(size * std::sqrt(std::abs(frame_from_px.inverse().determinant())));
  if (!fit_frame.mapping()) return;
  const double unit_mm = fit_frame.unit();
  fit.center_optical =
      PositionEstimate<frame::Optical>{fit_frame.to_optical(at), unit_mm * unit_mm * cov};
  fit.size_mm = mm(size * unit_mm);
}

std::optional<double> size_ratio(const TargetFit& fit, const Target& target) {
  if (target.size && fit.size_mm) return fit.size_mm->in_mm() / target.size->in_mm();
  if (target.size_px) return fit.size.in_px() / target.size_px->in_px();
  return std::nullopt;
}

}  // namespace panelcal::internal
