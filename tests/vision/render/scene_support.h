// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "vision/render/render.h"
#include <Eigen/Core>

namespace panelcal::test {

inline constexpr double kScale_mm = 0.01;

/// 200 x 180 px, 0.01 mm per px, the axis off the middle and a little turned; levels 0 to 1.
inline Camera scene_camera(double blur_px = 1) {
  CameraMapping::Parameters parameters;
  parameters.scale_mm_per_px = kScale_mm;
  parameters.rotation_rad = 0.02;
  parameters.axis_px = {103, 88};
  Camera camera{.mapping = CameraMapping(parameters)};
  camera.width = 200;
  camera.height = 180;
  camera.blur_px = blur_px;
  camera.full_scale = 1;
  return camera;
}

/// One feature on black ground.
inline Scene scene_of(const std::vector<Feature>& features) {
  Scene scene;
  scene.background = 0;
  scene.features = features;
  return scene;
}

/// Weight and centre of gravity of a picture.
struct Moments {
  double sum = 0;
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
};

inline Moments moments_of(std::span<const double> levels, int width) {
  Moments moments;
  const auto n_columns = static_cast<std::size_t>(width);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    moments.sum += levels[i];
    moments.center_px += levels[i] * Eigen::Vector2d(static_cast<double>(i % n_columns),
                                                     static_cast<double>(i / n_columns));
  }
  moments.center_px /= moments.sum;
  return moments;
}

inline double level_at(const std::vector<double>& levels, const Camera& camera, int x, int y) {
  return levels[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
                static_cast<std::size_t>(x)];
}

}  // namespace panelcal::test
