// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/fit/spline_image.h"
#include "vision/render/scene.h"
#include "vision/render/scene_projection.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// A picture lying on the board, as the camera sees it.
///
/// Between its pixels it is a cubic spline that passes through them, continued at its borders by
/// reflection. Where the camera's pixels are larger than its
/// own, they average it over their area.
class PictureSampler {
 public:
  /// Precondition: the feature has a picture, not empty.
  PictureSampler(const Feature& feature, const SceneProjection& projection);

  /// Brightness that a pixel of the camera sees, 0 to 1 of full scale (a spline may overshoot).
  double level(const Eigen::Vector2d& u_px) const;

 private:
  double spline(const Eigen::Vector2d& at_px) const;

  const SceneProjection& projection_;
  Eigen::Vector2d center_mm_;
  Eigen::Matrix2d picture_from_board_;  ///< px per mm
  Eigen::Vector2d reference_px_;
  int width_;
  int height_;
  int n_points_;  ///< per camera pixel and axis
  Raster coefficients_;
};

}  // namespace panelcal::internal
