// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/area.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include "calib/base/plane_vectors.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using Eigen::Vector2d;
using internal::cross;
using Corners = std::vector<Position<frame::Nominal>>;

/// Of a polygon each side is held against each other one.
constexpr std::size_t kMaxAreaCorners = 2000;
constexpr std::size_t kMostPoints = 10'000;
/// A kilometer: no table is larger.
constexpr double kFarthest_mm = 1e6;

double edge_distance_mm(const Vector2d& p_mm, const Vector2d& from_mm, const Vector2d& to_mm) {
  const Vector2d along_mm = to_mm - from_mm;
  const double squared_mm2 = along_mm.squaredNorm();
  const double t =
      squared_mm2 > 0 ? std::clamp((p_mm - from_mm).dot(along_mm) / squared_mm2, 0.0, 1.0) : 0;
  return (p_mm - from_mm - t * along_mm).norm();
}

/// The least distance to any side.
double border_distance_mm(const Corners& corners, const Vector2d& p_mm, bool is_closed) {
  double least_mm = (corners.front().in_mm() - p_mm).norm();
  for (std::size_t i = is_closed ? 0 : 1; i < corners.size(); ++i) {
    const Vector2d& from_mm = corners[i > 0 ? i - 1 : corners.size() - 1].in_mm();
    least_mm = std::min(least_mm, edge_distance_mm(p_mm, from_mm, corners[i].in_mm()));
  }
  return least_mm;
}

/// True if a ray from the place to the right crosses the border an odd number of times.
bool is_inside(const Corners& corners, const Vector2d& p_mm) {
  bool out = false;
  for (std::size_t i = 0, before = corners.size() - 1; i < corners.size(); before = i++) {
    const Vector2d& a_mm = corners[i].in_mm();
    const Vector2d& b_mm = corners[before].in_mm();
    if ((a_mm.y() > p_mm.y()) == (b_mm.y() > p_mm.y())) continue;
    const double t = (p_mm.y() - a_mm.y()) / (b_mm.y() - a_mm.y());
    if (p_mm.x() < a_mm.x() + t * (b_mm.x() - a_mm.x())) out = !out;
  }
  return out;
}

/// True if two sides have a point in common that is inside of both.
bool cross_each_other(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const double c_side = cross(b - a, c - a), d_side = cross(b - a, d - a);
  const double a_side = cross(d - c, a - c), b_side = cross(d - c, b - c);
  return ((c_side > 0 && d_side < 0) || (c_side < 0 && d_side > 0)) &&
         ((a_side > 0 && b_side < 0) || (a_side < 0 && b_side > 0));
}

bool crosses_itself(const Corners& corners) {
  const auto corner = [&](std::size_t i) -> const Vector2d& {
    return corners[i % corners.size()].in_mm();
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t j = i + 2; j < corners.size(); ++j) {
      if (cross_each_other(corner(i), corner(i + 1), corner(j), corner(j + 1))) return true;
    }
  }
  return false;
}

double doubled_area_mm2(const Corners& corners) {
  double out = 0;
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    out += cross((corners[i] - corners[0]).in_mm(), (corners[i + 1] - corners[0]).in_mm());
  }
  return std::abs(out);
}

/// Description of a fault and of the expected input; empty if there is no fault.
using Problem = std::pair<std::string, std::string>;

bool all_near(const Corners& corners) {
  return std::ranges::all_of(corners, [](const auto& corner) {
    return std::abs(corner.in_mm().x()) <= kFarthest_mm &&
           std::abs(corner.in_mm().y()) <= kFarthest_mm;
  });
}

bool is_size(Length size) {
  return size > mm(0) && size.in_mm() <= kFarthest_mm;
}

Problem area_problem(const Circle& circle) {
  if (!all_near({circle.center}))
    return {"a center that is not finite or too far away", "numbers up to 1e6 mm"};
  if (is_size(circle.radius)) return {};
  return {fmt::format("a circle of radius {} mm", circle.radius.in_mm()), "above 0 mm, to 1e6 mm"};
}

Problem area_problem(const Polygon& polygon) {
  if (polygon.corners.size() < 3 || polygon.corners.size() > kMaxAreaCorners) {
    return {fmt::format("a polygon of {} corners", polygon.corners.size()),
            fmt::format("3 to {}", kMaxAreaCorners)};
  }
  if (!all_near(polygon.corners))
    return {"a corner that is not finite or too far away", "numbers up to 1e6 mm"};
  if (!(doubled_area_mm2(polygon.corners) > 0)) return {"a polygon without an area", "one"};
  if (crosses_itself(polygon.corners)) {
    return {"a polygon whose sides cross", "its corners in order"};
  }
  return {};
}

Problem area_problem(const Track& track) {
  if (track.points.empty() || track.points.size() > kMostPoints) {
    return {fmt::format("a track of {} points", track.points.size()),
            fmt::format("1 to {}", kMostPoints)};
  }
  if (!all_near(track.points))
    return {"a point that is not finite or too far away", "numbers up to 1e6 mm"};
  if (is_size(track.width)) return {};
  return {fmt::format("a track of width {} mm", track.width.in_mm()), "above 0 mm, to 1e6 mm"};
}

Problem area_problem(const Outside& outside) {
  return area_problem(outside.panel);
}

/// The border belongs to an area; what rounding makes of a place on it is that far off.
constexpr double kOnBorder_mm = 1e-9;

bool is_in(const Circle& circle, const Vector2d& p_mm, double margin_mm) {
  return (p_mm - circle.center.in_mm()).norm() <= circle.radius.in_mm() + margin_mm;
}

bool is_in(const Polygon& polygon, const Vector2d& p_mm, double margin_mm) {
  return is_inside(polygon.corners, p_mm) ||
         border_distance_mm(polygon.corners, p_mm, true) <= margin_mm + kOnBorder_mm;
}

bool is_in(const Track& track, const Vector2d& p_mm, double margin_mm) {
  return border_distance_mm(track.points, p_mm, false) <= 0.5 * track.width.in_mm() + margin_mm;
}

bool is_in(const Outside& outside, const Vector2d& p_mm, double margin_mm) {
  return !is_inside(outside.panel.corners, p_mm) ||
         border_distance_mm(outside.panel.corners, p_mm, true) <= margin_mm + kOnBorder_mm;
}

AreaBox box_about(const Corners& corners, double margin_mm) {
  AreaBox out{corners.front().in_mm(), corners.front().in_mm()};
  for (const auto& corner : corners) {
    out.low_mm = out.low_mm.cwiseMin(corner.in_mm());
    out.high_mm = out.high_mm.cwiseMax(corner.in_mm());
  }
  const Vector2d margin = Vector2d::Constant(margin_mm);
  return {out.low_mm - margin, out.high_mm + margin};
}

AreaBox box_about(const Circle& circle) {
  return box_about(Corners{circle.center}, circle.radius.in_mm());
}

AreaBox box_about(const Polygon& polygon) {
  return box_about(polygon.corners, 0);
}

AreaBox box_about(const Track& track) {
  return box_about(track.points, 0.5 * track.width.in_mm());
}

AreaBox box_about(const Outside&) {
  const Vector2d all = Vector2d::Constant(std::numeric_limits<double>::infinity());
  return {-all, all};
}

}  // namespace

Polygon rectangle(const Position<frame::Nominal>& low, const Position<frame::Nominal>& high) {
  const Vector2d &a_mm = low.in_mm(), &b_mm = high.in_mm();
  return {{low,
           position_mm<frame::Nominal>(b_mm.x(), a_mm.y()),
           high,
           position_mm<frame::Nominal>(a_mm.x(), b_mm.y())}};
}

Expected<void> check_area(const Area& area, std::string_view name, const Place& from) {
  auto [what, expected] = std::visit([](const auto& shape) { return area_problem(shape); }, area);
  if (what.empty()) return {};
  return failure(
      {Code::ConfigValue, from, fmt::format("{}: {}", quoted(name), what), std::move(expected)});
}

bool is_within(const Area& area, const Position<frame::Nominal>& place, Length margin) {
  return std::visit([&](const auto& shape) { return is_in(shape, place.in_mm(), margin.in_mm()); },
                    area);
}

AreaBox box_of(const Area& area) {
  return std::visit([](const auto& shape) { return box_about(shape); }, area);
}

}  // namespace panelcal
