// SPDX-License-Identifier: Apache-2.0
#include "vision/show/shown_box.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace panelcal::internal {
namespace {

using Outlines = std::vector<std::vector<Eigen::Vector2d>>;

/// Extent of outlines from a place, each axis for itself, px.
double reach_of(const Outlines& outlines_px, PixelLength size, const Eigen::Vector2d& from_px) {
  double reach_px = 0.5 * size.in_px();
  for (const auto& outline : outlines_px) {
    for (const Eigen::Vector2d& u : outline) {
      reach_px = std::max(reach_px, (u - from_px).lpNorm<Eigen::Infinity>());
    }
  }
  return reach_px;
}

/// Half the side of a square about the best candidate that shows all that matters, px.
double half_width_of(const Detection& detection) {
  const TargetFit& best = *detection.best;
  const Eigen::Vector2d& u = best.center.position.in_px();
  double half_px = 1.6 * reach_of(best.outlines_px, best.size, u) + 8;
  for (const Candidate& other : detection.candidates) {
    if (!other.reason.empty()) continue;
    half_px = std::max(half_px, reach_of(other.outlines_px, other.size, u) + 8);
    half_px = std::max(half_px, (other.center.in_px() - u).lpNorm<Eigen::Infinity>() + 8);
  }
  return half_px;
}

}  // namespace

cv::Rect shown_box(const Image& image,
                   const Detection& detection,
                   std::optional<PixelLength> half_width) {
  const cv::Rect whole(0, 0, image.width(), image.height());
  if (!detection.best) return whole;
  const Eigen::Vector2d& u = detection.best->center.position.in_px();
  const double half = half_width ? half_width->in_px() : half_width_of(detection);
  const auto clamped = [](double v, int end) {
    if (std::isnan(v)) return end;
    return static_cast<int>(std::lround(std::clamp(v, 0.0, static_cast<double>(end))));
  };
  const cv::Point first(clamped(u.x() - half, image.width()),
                        clamped(u.y() - half, image.height()));
  const cv::Point last(clamped(u.x() + half + 1, image.width()),
                       clamped(u.y() + half + 1, image.height()));
  return last.x > first.x && last.y > first.y ? cv::Rect(first, last) : whole;
}

}  // namespace panelcal::internal
