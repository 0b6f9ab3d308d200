// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/circle_bias.h"

#include <Eigen/LU>

namespace panelcal {
namespace {

/// Step of the differences of the Jacobian. K is smooth over hundreds of pixels, so both what is
/// cut off (step / 1000 px, squared) and rounding (1e-16 / step) are far below what matters.
constexpr double kStep_px = 0.5;

/// dJ/du_l by central differences.
Eigen::Matrix2d curvature(const CameraModel& camera, const Position<frame::Image>& u, int l) {
  const auto step = displacement_px<frame::Image>(kStep_px * Eigen::Vector2d::Unit(l));
  return (camera.jacobian(u + step) - camera.jacobian(u - step)) / (2 * kStep_px);
}

}  // namespace

Displacement<frame::Image> circle_bias(const CameraModel& camera,
                                       const Position<frame::Image>& u,
                                       Length radius) {
  // Everything by the derivatives of K, the inverse of u(p): du/dp = J^-1, and from
  // K(u(p)) = p differentiated twice, d2u_m / dp dp = -sum_k (J^-1)_mk J^-T (d2K_k / du du) J^-1.
  const Eigen::Matrix2d back = camera.jacobian(u).inverse();
  const Eigen::Matrix2d spread = back * back.transpose();
  Eigen::Vector2d grad_log;                              // of |dK/du|
  Eigen::Vector2d laplace_mm = Eigen::Vector2d::Zero();  // of K, in the metric of the panel
  for (int l = 0; l < 2; ++l) {
    const Eigen::Matrix2d by_l = curvature(camera, u, l);  // (k, i): d2K_k / du_i du_l
    grad_log[l] = (back * by_l).trace();
    laplace_mm += by_l * spread.col(l);
  }
  const Eigen::Vector2d second = -spread * grad_log - 0.5 * back * laplace_mm;
  return displacement_px<frame::Image>(0.25 * radius.in_mm() * radius.in_mm() * second);
}

}  // namespace panelcal
