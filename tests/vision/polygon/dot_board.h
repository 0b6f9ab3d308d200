// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "calib/base/statistics/random.h"
#include "vision/locate/locate.h"
#include "vision/render/render.h"
#include <Eigen/Core>

#include "tests/vision/trial.h"

namespace panelcal::test {

inline constexpr double kDotScaleMm = 0.01;
inline constexpr double kDotRadiusPx = 8;
inline constexpr double kDotLevel = 180.0 / 255;

/// Five dots without any symmetry, mm from the code's place.
inline const std::vector<Eigen::Vector2d> kCode = {
    {-0.6, -0.4}, {0.6, -0.45}, {0.5, 0.5}, {-0.2, 0.3}, {0.1, -0.1}};

inline Eigen::Vector2d turned(const Eigen::Vector2d& v, double angle) {
  return {std::cos(angle) * v.x() - std::sin(angle) * v.y(),
          std::sin(angle) * v.x() + std::cos(angle) * v.y()};
}

/// A dot-code and other dots under a camera.
struct DotBoard {
  Camera camera = plain_camera(260, 240);
  Scene scene;
  Target target;

  DotBoard() {
    scene.background = 80.0 / 255;
    camera.noise = 2;
    target.shape = Shape::Dots;
    target.size = mm(2 * kDotRadiusPx * kDotScaleMm);
    target.dots = kCode;
  }
  void add(const Eigen::Vector2d& at_mm) {
    Feature dot;
    dot.center = position_mm<frame::Optical>(at_mm);
    dot.size = *target.size;
    dot.level = kDotLevel;
    scene.features.push_back(dot);
  }
  void add_code(const Eigen::Vector2d& at_mm, double turn, double scale = 1) {
    for (const auto& dot : target.dots) add(at_mm + scale * turned(dot, turn));
  }
  Detection locate(std::uint64_t seed = 1, const LocateOptions& options = {}) const {
    Random random(seed);
    return panelcal::locate(render(scene, camera, random), target, &camera.mapping, options);
  }
};

}  // namespace panelcal::test
