// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/search_area.h"

#include <algorithm>
#include <cmath>

namespace panelcal::internal {

SearchArea::SearchArea(const LocateOptions& options) {
  if (!options.search_center || !options.search_radius) return;
  center_px_ = options.search_center->in_px();
  radius_px_ = options.search_radius->in_px();
}

PixelBox SearchArea::box(const Image& image, double reach_px) const {
  if (!center_px_) return {0, 0, image.width(), image.height()};
  const double reach = radius_px_ + reach_px;
  const auto clamped = [](double v, int end) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(end)));
  };
  PixelBox box;
  box.x0 = clamped(std::floor(center_px_->x() - reach), image.width());
  box.y0 = clamped(std::floor(center_px_->y() - reach), image.height());
  box.width = clamped(std::ceil(center_px_->x() + reach) + 1, image.width()) - box.x0;
  box.height = clamped(std::ceil(center_px_->y() + reach) + 1, image.height()) - box.y0;
  return box;
}

}  // namespace panelcal::internal
