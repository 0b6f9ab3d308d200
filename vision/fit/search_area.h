// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "vision/fit/detection.h"
#include "vision/picture/image.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// A rectangle of pixels.
struct PixelBox {
  int x0 = 0;
  int y0 = 0;
  int width = 0;
  int height = 0;
};

/// The pixels of a picture from the one before `low` to the one behind `high`.
PixelBox pixels_between(const Eigen::Vector2d& low,
                        const Eigen::Vector2d& high,
                        const Image& image);

/// Area in which targets' places may be: a circle, or the whole picture.
class SearchArea {
 public:
  explicit SearchArea(const LocateOptions& options);

  bool contains(const Eigen::Vector2d& u_px, double slack_px) const {
    return !center_px_ || (u_px - *center_px_).norm() <= radius_px_ + slack_px;
  }
  /// The pixels within `reach_px` of any place that is searched.
  PixelBox box(const Image& image, double reach_px) const;

 private:
  std::optional<Eigen::Vector2d> center_px_;
  double radius_px_ = 0;
};

}  // namespace panelcal::internal
