// SPDX-License-Identifier: Apache-2.0
#include "machine/look/search_spiral.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::size_t kMaxSpiralViews = 400;
/// Pincushion and barrel make a picture's sides bend by less than this between their middles and
/// ends in any usable lens; taken off the rectangle, beside its least chord.
constexpr double kStraightness = 0.98;

/// Steps of a square spiral: ring r begins beside the end of ring r - 1.
std::vector<Eigen::Vector2i> ring(int r) {
  std::vector<Eigen::Vector2i> cells;
  if (r == 0) return {Eigen::Vector2i(0, 0)};
  for (int j = -r + 1; j <= r; ++j) cells.emplace_back(r, j);
  for (int i = r - 1; i >= -r; --i) cells.emplace_back(i, r);
  for (int j = r - 1; j >= -r; --j) cells.emplace_back(-r, j);
  for (int i = -r + 1; i <= r; ++i) cells.emplace_back(i, -r);
  return cells;
}

}  // namespace

Expected<UsableView> usable_view(const ZoomedCamera& camera, Length margin) {
  const double margin_px = margin.in_mm() / camera.mapping.parameters().scale_mm_per_px;
  const double left_px = margin_px;
  const double right_px = camera.width_px - 1 - margin_px;
  const double top_px = margin_px;
  const double bottom_px = camera.height_px - 1 - margin_px;
  if (!(right_px > left_px) || !(bottom_px > top_px)) {
    return failure({Code::NotSupported,
                    {},
                    fmt::format("pictures of {} x {} px overlap by {:.1f} px in a search",
                                camera.width_px,
                                camera.height_px,
                                2 * margin_px),
                    "a smaller target, or a lower zoom"});
  }
  const auto seen = [&](double x_px, double y_px) {
    return camera.mapping(position_px(x_px, y_px)).in_mm();
  };
  const double middle_x_px = 0.5 * (left_px + right_px);
  const double middle_y_px = 0.5 * (top_px + bottom_px);
  const Eigen::Vector2d direction =
      (seen(right_px, middle_y_px) - seen(left_px, middle_y_px)).normalized();
  double along_mm = INFINITY;
  for (const double y_px : {top_px, middle_y_px, bottom_px}) {
    along_mm = std::min(along_mm, (seen(right_px, y_px) - seen(left_px, y_px)).norm());
  }
  double across_mm = INFINITY;
  for (const double x_px : {left_px, middle_x_px, right_px}) {
    across_mm = std::min(across_mm, (seen(x_px, bottom_px) - seen(x_px, top_px)).norm());
  }
  return UsableView{seen(middle_x_px, middle_y_px),
                    kStraightness * along_mm * direction,
                    kStraightness * across_mm * Eigen::Vector2d(-direction.y(), direction.x())};
}

Expected<std::vector<Position<frame::Machine>>> search_spiral(
    const Position<frame::Machine>& expected, Length radius, const UsableView& view) {
  const double along_mm = view.along_mm.norm();
  const double across_mm = view.across_mm.norm();
  const double radius_mm = radius.in_mm();
  const Eigen::Vector2d along = view.along_mm / along_mm;
  const Eigen::Vector2d across = view.across_mm / across_mm;
  const auto touches = [&](const Eigen::Vector2d& step_mm) {
    const Eigen::Vector2d middle_mm = step_mm + view.middle_mm;
    const double x_mm = std::max(0.0, std::abs(along.dot(middle_mm)) - along_mm / 2);
    const double y_mm = std::max(0.0, std::abs(across.dot(middle_mm)) - across_mm / 2);
    return std::hypot(x_mm, y_mm) <= radius_mm;
  };
  const double reach_mm = radius_mm + view.middle_mm.norm() + std::max(along_mm, across_mm);
  const double n_views = 3.2 * radius_mm * radius_mm / (along_mm * across_mm);
  std::vector<Position<frame::Machine>> places = {expected};
  for (int r = 1; n_views < kMaxSpiralViews && r * std::min(along_mm, across_mm) <= reach_mm; ++r) {
    for (const Eigen::Vector2i& cell : ring(r)) {
      const Eigen::Vector2d step_mm = cell.x() * view.along_mm + cell.y() * view.across_mm;
      if (touches(step_mm)) places.push_back(expected + displacement_mm<frame::Machine>(step_mm));
    }
  }
  if (n_views < kMaxSpiralViews && places.size() <= kMaxSpiralViews) return places;
  return failure({Code::NotSupported,
                  {},
                  fmt::format("a search of radius {:.3f} mm needs about {:.0f} views of {:.3f} x "
                              "{:.3f} mm",
                              radius_mm,
                              std::max(n_views, static_cast<double>(places.size())),
                              along_mm,
                              across_mm),
                  fmt::format("a search area of at most {} views", kMaxSpiralViews)});
}

}  // namespace panelcal
