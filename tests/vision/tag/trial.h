// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "calib/base/statistics/random.h"
#include "vision/picture/image.h"
#include "vision/tag/family.h"
#include <Eigen/Core>

namespace panelcal::test {

/// A tag under a camera, in any perspective.
struct TagScene {
  TagPattern pattern;
  Eigen::Matrix3d image_from_tag = Eigen::Matrix3d::Identity();
  int width = 640;
  int height = 480;
  double black = 60;  ///< levels of 255, at the tag's middle
  double white = 200;
  double around = 130;  ///< level around the tag and in cells of no matter
  double blur_px = 1;   ///< of the lens
  double noise = 2;     ///< sigma, levels of 255
  /// Relative change of the light over the picture's width and height.
  Eigen::Vector2d light_gradient = Eigen::Vector2d::Zero();
  double full_scale = 255;

  Eigen::Vector2d center_px() const;
  std::array<Eigen::Vector2d, 4> corners_px() const;  ///< in the order of tag_corners()
};

/// The place in the picture of a place in the tag's frame.
Eigen::Vector2d project(const Eigen::Matrix3d& image_from_tag, const Eigen::Vector2d& at);

/// Levels that a camera without noise and rounding sees, by rows: area shares are exact
/// (coverage.h).
std::vector<double> tag_levels(const TagScene& scene);

/// A picture of it with noise, rounded to whole levels and clipped.
Image tag_picture(const TagScene& scene, Random& random);
/// Likewise of levels that something was painted over.
Image noisy_picture(const TagScene& scene, const std::vector<double>& levels, Random& random);

/// A tag turned at random about all three axes and moved by up to 20 px from the middle.
///
/// In     side_px: mean side; tilt_rad: largest angle between tag and picture; the camera looks
///        from 5 sides' distance
Eigen::Matrix3d random_pose(const TagScene& scene, double side_px, double tilt_rad, Random& random);

/// Square root of the Cramer-Rao bounds of a tag's places under the scene's white noise.
struct TagBound {
  double center_px = 0;  ///< of one coordinate, the mean of x and y (root of mean square)
  double corner_px = 0;  ///< likewise, and of the four corners
};

/// By numeric derivatives of tag_levels(), with the eight numbers of the pose, both levels, their
/// slopes and the blur unknown.
TagBound tag_bound(const TagScene& scene);

}  // namespace panelcal::test
