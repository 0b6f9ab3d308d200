// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>

#include "calib/base/statistics/random.h"
#include "vision/picture/image.h"
#include <Eigen/Core>

namespace panelcal::test {

/// True if a place is inside of a shape about (0, 0), px.
using Inside = std::function<bool(const Eigen::Vector2d&)>;

inline Inside disc_of(double diameter) {
  return [r = diameter / 2](const Eigen::Vector2d& v) { return v.norm() < r; };
}

inline Inside turned(const Inside& inside, double angle_rad) {
  return [=](const Eigen::Vector2d& v) {
    const double c = std::cos(angle_rad);
    const double s = std::sin(angle_rad);
    return inside({c * v.x() + s * v.y(), c * v.y() - s * v.x()});
  };
}

inline Inside square_of(double side) {
  return [h = side / 2](const Eigen::Vector2d& v) { return v.cwiseAbs().maxCoeff() < h; };
}

inline Inside cross_of(double length, double width) {
  return [=](const Eigen::Vector2d& v) {
    const Eigen::Vector2d a = v.cwiseAbs();
    return a.maxCoeff() < length / 2 && a.minCoeff() < width / 2;
  };
}

/// Gives the pixels of a shape another level, with soft rims: the mean of 5 x 5 places a pixel.
inline void draw(Image& image, const Inside& inside, const Eigen::Vector2d& at_px, float level) {
  constexpr int kPlaces = 5;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      int n = 0;
      for (int k = 0; k < kPlaces * kPlaces; ++k) {
        const Eigen::Vector2d u(x + (k % kPlaces + 0.5) / kPlaces - 0.5,
                                y + (k / kPlaces + 0.5) / kPlaces - 0.5);
        n += inside(u - at_px) ? 1 : 0;
      }
      const float part = static_cast<float>(n) / (kPlaces * kPlaces);
      image.at(x, y) += part * (level - image.at(x, y));
    }
  }
}

inline void add_noise(Image& image, double sigma, std::uint64_t seed) {
  Random random(seed);
  for (float& level : image.pixels()) level += static_cast<float>(sigma * random.normal());
}

}  // namespace panelcal::test
