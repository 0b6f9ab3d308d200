// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/blanks.h"

#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>
#include <variant>
#include <vector>

#include "calib/base/append_format.h"
#include "tools/figures/contour_map.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

using Eigen::Vector2d;
using report::View;

/// Smaller holes are dots of this radius, and one stands for all in a square of this side.
constexpr double kBlankDot_px = 0.8;
constexpr double kDotSide_px = 1.5;
constexpr double kOutline_px = 0.8;
constexpr int kCircleCorners = 64;

std::string corners_path(const View& view, const std::vector<Position<frame::Nominal>>& corners) {
  std::vector<Vector2d> corners_mm;
  for (const auto& corner : corners) corners_mm.push_back(corner.in_mm());
  return contours::polygon_path(view, corners_mm);
}

/// Of an area that zones have.
std::string border_path(const View& view, const Area& area) {
  if (const auto* polygon = std::get_if<Polygon>(&area))
    return corners_path(view, polygon->corners);
  const auto* circle = std::get_if<Circle>(&area);
  if (circle == nullptr) return {};
  std::vector<Position<frame::Nominal>> corners;
  for (int k = 0; k < kCircleCorners; ++k) {
    const double angle_rad = 2 * std::numbers::pi * k / kCircleCorners;
    corners.push_back(circle->center + displacement_mm<frame::Nominal>(
                                           circle->radius.in_mm() * std::cos(angle_rad),
                                           circle->radius.in_mm() * std::sin(angle_rad)));
  }
  return corners_path(view, corners);
}

/// Path of everything about an area within the frame.
std::string around_path(const View& view, const std::string& border) {
  return contours::frame_path(view) + border;
}

/// Paths that are filled, and lines by their width.
struct Shapes {
  std::string areas;
  std::map<double, std::string> lines_px;
};

bool is_shown(const View& view, const Area& area) {
  const AreaBox box = box_of(area);
  return (box.low_mm.array() <= view.shown().high_mm.array()).all() &&
         (box.high_mm.array() >= view.shown().low_mm.array()).all();
}

std::string circle_path(const Vector2d& at, double radius) {
  return fmt::format(
      "M{0:.1f} {1:.1f}a{2:.1f} {2:.1f} 0 1 0 {3:.1f} 0a{2:.1f} {2:.1f} 0 1 0 -{3:.1f} 0",
      at.x() - radius,
      at.y(),
      radius,
      2 * radius);
}

Shapes shapes_of(const Voids& voids, const View& view) {
  Shapes out;
  std::set<std::pair<long, long>> dots;
  for (const Void& one : voids.all()) {
    if (!is_shown(view, one.area)) continue;
    if (const auto* circle = std::get_if<Circle>(&one.area)) {
      const Vector2d at = view.at(circle->center.in_mm());
      const double radius = view.px_per_mm() * circle->radius.in_mm();
      if (radius > kBlankDot_px) {
        out.areas += circle_path(at, radius);
      } else if (dots.emplace(std::lround(at.x() / kDotSide_px), std::lround(at.y() / kDotSide_px))
                     .second) {
        out.areas += circle_path(at, kBlankDot_px);
      }
    } else if (const auto* polygon = std::get_if<Polygon>(&one.area)) {
      out.areas += corners_path(view, polygon->corners);
    } else if (const auto* outside = std::get_if<Outside>(&one.area)) {
      out.areas += around_path(view, corners_path(view, outside->panel.corners));
    } else if (const auto* track = std::get_if<Track>(&one.area)) {
      std::string& path = out.lines_px[view.px_per_mm() * track->width.in_mm()];
      char word = 'M';
      for (const auto& point : track->points) {
        const Vector2d at = view.at(point.in_mm());
        internal::append_format(path, "{}{:.1f} {:.1f}", word, at.x(), at.y());
        word = 'L';
      }
      if (track->points.size() == 1) path += "h0";
    }
  }
  return out;
}

/// First everything a little wider and dark, then white: what overlaps has one outline.
std::string void_marks(const Voids& voids, const View& view) {
  const Shapes shapes = shapes_of(voids, view);
  std::string out;
  if (!shapes.areas.empty()) out += fmt::format("<path class=\"edge\" d=\"{}\"/>\n", shapes.areas);
  for (const bool is_white : {false, true}) {
    for (const auto& [width, path] : shapes.lines_px) {
      out += fmt::format("<path class=\"{}\" style=\"stroke-width:{:.1f}px\" d=\"{}\"/>\n",
                         is_white ? "gap" : "edge",
                         is_white ? width : width + 2 * kOutline_px,
                         path);
    }
  }
  if (!shapes.areas.empty()) out += fmt::format("<path class=\"blank\" d=\"{}\"/>\n", shapes.areas);
  return out;
}

}  // namespace

std::string blanks(const ZonedMap& map, std::size_t i_zone, const View& view) {
  std::string out, borders;
  for (std::size_t i = 0; i < map.zones().size(); ++i) {
    const std::string border = border_path(view, map.zones()[i].area);
    // Earlier zones hold what they share with this one.
    if (i < i_zone) out += fmt::format("<path class=\"blank\" d=\"{}\"/>\n", border);
    if (i == i_zone) {
      out += fmt::format("<path class=\"blank\" d=\"{}\"/>\n", around_path(view, border));
    }
    borders +=
        fmt::format("<path class=\"{}\" d=\"{}\"/>\n", i == i_zone ? "zone own" : "zone", border);
  }
  return out + borders + void_marks(map.voids(), view);
}

}  // namespace panelcal::surface
