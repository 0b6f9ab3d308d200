// SPDX-License-Identifier: Apache-2.0
#include "vision/render/scene_projection.h"

#include <cmath>

namespace panelcal::internal {
namespace {

/// Shrinks by `factor` across the axis of the tilt.
Eigen::Matrix2d across_axis(Angle axis, double factor) {
  const Eigen::Vector2d across(-std::sin(axis.in_rad()), std::cos(axis.in_rad()));
  return Eigen::Matrix2d::Identity() + (factor - 1) * across * across.transpose();
}

}  // namespace

SceneProjection::SceneProjection(const Camera& camera)
    : mapping_(camera.mapping),
      seen_from_board_(across_axis(camera.tilt_axis, std::cos(camera.tilt.in_rad()))),
      board_from_seen_(across_axis(camera.tilt_axis, 1 / std::cos(camera.tilt.in_rad()))) {
}

std::optional<Eigen::Vector2d> SceneProjection::image_of(const Eigen::Vector2d& at_mm) const {
  const Eigen::Vector2d seen_mm = seen_from_board_ * at_mm;
  const auto u = mapping_.image_of(position_mm<frame::Optical>(seen_mm));
  if (!u) return std::nullopt;
  return u->in_px();
}

Eigen::Vector2d SceneProjection::board_of(const Eigen::Vector2d& u_px) const {
  return board_from_seen_ * mapping_(position_px<frame::Image>(u_px)).in_mm();
}

Eigen::Matrix2d SceneProjection::jacobian(const Eigen::Vector2d& u_px) const {
  return board_from_seen_ * mapping_.jacobian(position_px<frame::Image>(u_px));
}

}  // namespace panelcal::internal
