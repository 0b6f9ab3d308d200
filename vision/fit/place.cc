// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/place.h"

#include <cmath>

#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {

void set_place(const FitFrame& fit_frame,
               const Eigen::Vector2d& at,
               const Eigen::Matrix2d& cov,
               double size,
               TargetFit& fit) {
  const Eigen::Vector2d u = fit_frame.to_image(at).value_or(Eigen::Vector2d::Zero());
  const Eigen::Matrix2d px_from_frame = fit_frame.jacobian(u).inverse();
  fit.center = {position_px<frame::Image>(u), propagate(px_from_frame, cov)};
  fit.size = px(size * std::sqrt(std::abs(px_from_frame.determinant())));
  if (!fit_frame.mapping()) return;
  const double unit_mm = fit_frame.unit();
  fit.center_optical =
      PositionEstimate<frame::Optical>{fit_frame.to_optical(at), unit_mm * unit_mm * cov};
  fit.size_mm = mm(size * unit_mm);
}

std::optional<std::string> size_problem(
    const FitFrame& fit_frame, std::string_view what, double seen, double asked, double tolerance) {
  const double deviation = seen / asked - 1;
  if (std::abs(deviation) <= tolerance) return std::nullopt;
  const double unit = fit_frame.unit();
  return fmt::format("{} is {:.4g} {}, {:+.1f} % from {:.4g}; {:.1f} % are allowed",
                     what,
                     seen * unit,
                     fit_frame.mapping() ? "mm" : "px",
                     100 * deviation,
                     asked * unit,
                     100 * tolerance);
}

std::optional<double> size_ratio(const TargetFit& fit, const Target& target) {
  if (target.size && fit.size_mm) return fit.size_mm->in_mm() / target.size->in_mm();
  if (target.size_px) return fit.size.in_px() / target.size_px->in_px();
  return std::nullopt;
}

}  // namespace panelcal::internal
