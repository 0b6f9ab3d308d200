// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/search_area.h"

#include <algorithm>
#include <cmath>

namespace panelcal::internal {

PixelBox pixels_between(const Eigen::Vector2d& low,
                        const Eigen::Vector2d& high,
                        const Image& image) {
  const auto clamped = [](double v, int end) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(end)));
  };
  PixelBox box;
  box.x0 = clamped(std::floor(low.x()), image.width());
  box.y0 = clamped(std::floor(low.y()), image.height());
  box.width = clamped(std::ceil(high.x()) + 1, image.width()) - box.x0;
  box.height = clamped(std::ceil(high.y()) + 1, image.height()) - box.y0;
  return box;
}

SearchArea::SearchArea(const LocateOptions& options) {
  if (!options.search_center || !options.search_radius) return;
  center_px_ = options.search_center->in_px();
  radius_px_ = options.search_radius->in_px();
}

PixelBox SearchArea::box(const Image& image, double reach_px) const {
  if (!center_px_) return {0, 0, image.width(), image.height()};
  const double reach = radius_px_ + reach_px;
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(reach);
  return pixels_between(*center_px_ - half, *center_px_ + half, image);
}

}  // namespace panelcal::internal
