// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/fit_window.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace panelcal::internal {
namespace {

/// Deep inside every so many pixels in x and y are kept.
constexpr int kInsideStride = 4;

/// Lens distortion moves the box of a disc by less than this part of its radius.
constexpr double kBoxSlack = 0.05;

bool is_on_stride(int x, int y) {
  return x % kInsideStride == 0 && y % kInsideStride == 0;
}

}  // namespace

double white_noise_of(const FitWindow& window) {
  std::vector<double> differences;
  differences.reserve(window.pixels.size());
  for (std::size_t i = 1; i < window.pixels.size(); ++i) {
    const WindowPixel& a = window.pixels[i - 1];
    const WindowPixel& b = window.pixels[i];
    if (a.y == b.y && a.x + 1 == b.x) differences.push_back(std::abs(a.value - b.value));
  }
  if (differences.empty()) return 0;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return 1.4826 / std::sqrt(2.0) * *middle;
}

WindowReach window_reach(double radius_px) {
  WindowReach reach;
  reach.outside_px = std::clamp(8 + 0.4 * radius_px, 10.0, 26.0);
  reach.inside_px = 40;
  return reach;
}

FitWindow make_window(const Image& image,
                      const FitFrame& fit_frame,
                      const Eigen::Vector2d& center,
                      double radius,
                      const WindowReach& reach) {
  FitWindow window;
  const auto u = fit_frame.to_image(center);
  if (!u) return window;
  const double outer = radius + reach.outside_px;
  const double half = outer * (1 + kBoxSlack) + 1;
  const auto clamped = [](double v, int end) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(end)));
  };
  window.x0 = clamped(std::floor(u->x() - half), image.width());
  window.y0 = clamped(std::floor(u->y() - half), image.height());
  window.width = clamped(std::ceil(u->x() + half) + 1, image.width()) - window.x0;
  window.height = clamped(std::ceil(u->y() + half) + 1, image.height()) - window.y0;
  window.pixels.reserve(static_cast<std::size_t>(window.width) *
                        static_cast<std::size_t>(window.height));
  for (int y = window.y0; y < window.y0 + window.height; ++y) {
    for (int x = window.x0; x < window.x0 + window.width; ++x) {
      const Eigen::Vector2d pixel(x, y);
      const Eigen::Vector2d at = fit_frame.from_image(pixel);
      const double r = (at - center).norm();
      if (r > outer) continue;
      const bool in_fit = r > radius - reach.inside_px;
      if (!in_fit && !is_on_stride(x, y)) continue;
      window.pixels.push_back(
          {at, fit_frame.jacobian(pixel), image.at(x, y), 1.0, x, y, in_fit, false});
    }
  }
  return window;
}

}  // namespace panelcal::internal
