// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/camera/mapping.h"
#include "vision/render/camera.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// Projection by which a camera draws the board, which may be tilted: foreshortening first, then
/// the lens.
class SceneProjection {
 public:
  explicit SceneProjection(const Camera& camera);

  /// The picture of a place on the board, px; empty where the lens model cannot draw it, which is
  /// far outside of any picture.
  std::optional<Eigen::Vector2d> image_of(const Eigen::Vector2d& at_mm) const;
  /// The place on the board that a pixel sees, mm.
  Eigen::Vector2d board_of(const Eigen::Vector2d& u_px) const;
  /// d(board_of)/du, mm per px.
  Eigen::Matrix2d jacobian(const Eigen::Vector2d& u_px) const;
  double scale_mm_per_px() const { return mapping_.parameters().scale_mm_per_px; }

 private:
  CameraMapping mapping_;
  Eigen::Matrix2d seen_from_board_;
  Eigen::Matrix2d board_from_seen_;
};

}  // namespace panelcal::internal
