// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <utility>

#include "surface/map/file_parts.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr double kMaxVoidLine = std::numeric_limits<int>::max();

MapArea written_form(const Circle& circle) {
  MapArea out;
  out.center = circle.center;
  out.diameter = 2 * circle.radius;
  return out;
}

MapArea written_form(const Polygon& polygon) {
  MapArea out;
  out.polygon = polygon.corners;
  return out;
}

MapArea written_form(const Track& track) {
  MapArea out;
  out.track = track.points;
  out.width = track.width;
  return out;
}

MapArea written_form(const Outside& outside) {
  MapArea out;
  out.outside = outside.panel.corners;
  return out;
}

/// The area of a form other than circles; empty if the members make none.
std::optional<Area> area_of(const MapArea& written) {
  const int n_members = written.polygon.has_value() + written.track.has_value() +
                        written.outside.has_value() + written.center.has_value() +
                        written.diameter.has_value() + written.width.has_value();
  if (written.polygon && n_members == 1) return Polygon{*written.polygon};
  if (written.outside && n_members == 1) return Outside{{*written.outside}};
  if (written.center && written.diameter && n_members == 2) {
    return Circle{*written.center, 0.5 * *written.diameter};
  }
  if (written.track && written.width && n_members == 2) {
    return Track{*written.track, *written.width};
  }
  return std::nullopt;
}

/// Of a circle that may share its element with the next ones.
const Circle* circle_of(const Void& hole) {
  return std::get_if<Circle>(&hole.area);
}

bool share_an_element(const Void& a, const Void& b) {
  return circle_of(a) != nullptr && circle_of(b) != nullptr && a.name == b.name &&
         a.from.file == b.from.file && circle_of(a)->radius == circle_of(b)->radius;
}

/// Appends the voids of an element; false: it has no area.
bool append_voids(const MapVoid& written, std::vector<Void>& out) {
  Void one;
  one.name = written.name;
  one.from.file = written.file;
  if (written.circles.empty()) {
    const std::optional<Area> area = area_of(written.area);
    if (!area || !written.line) return false;
    one.area = *area;
    one.from.line = *written.line;
    out.push_back(std::move(one));
    return true;
  }
  for (std::size_t i = 0; i < written.circles.size(); i += 3) {
    MapArea circle = written.area;
    circle.center = position_mm<frame::Nominal>(written.circles[i], written.circles[i + 1]);
    const double line = written.circles[i + 2];
    const std::optional<Area> area = area_of(circle);
    const bool is_line = line >= 0 && line <= kMaxVoidLine && line == std::floor(line);
    if (!area || !std::holds_alternative<Circle>(*area) || written.line || !is_line) return false;
    one.area = *area;
    one.from.line = static_cast<int>(line);
    out.push_back(one);
  }
  return true;
}

}  // namespace

MapArea written_area(const Area& area) {
  return std::visit([](const auto& form) { return written_form(form); }, area);
}

Expected<Area> zone_area(const MapArea& written, const std::string& name, const std::string& file) {
  const std::optional<Area> area = area_of(written);
  if (!area) {
    return failure(
        map_file_problem(file, name + " has no area", "either polygon, or center and diameter"));
  }
  PANELCAL_CHECK(check_area(*area, name, {file, 0, 0}));
  return *area;
}

std::vector<MapVoid> written_voids(std::span<const Void> voids) {
  std::vector<MapVoid> out;
  for (std::size_t i = 0; i < voids.size(); ++i) {
    const Void& hole = voids[i];
    const Circle* const circle = circle_of(hole);
    if (i == 0 || !share_an_element(voids[i - 1], hole)) {
      MapVoid& element = out.emplace_back();
      element.name = hole.name;
      element.file = hole.from.file;
      element.area = written_area(hole.area);
      element.area.center.reset();
      if (circle == nullptr) element.line = hole.from.line;
    }
    if (circle == nullptr) continue;
    const Eigen::Vector2d& at_mm = circle->center.in_mm();
    std::vector<double>& circles = out.back().circles;
    circles.insert(circles.end(), {at_mm.x(), at_mm.y(), static_cast<double>(hole.from.line)});
  }
  return out;
}

Expected<Voids> voids_of(const MapFile& written, const std::string& file) {
  std::vector<Void> all;
  for (std::size_t i = 0; i < written.voids.size(); ++i) {
    if (append_voids(written.voids[i], all)) continue;
    return failure(map_file_problem(file,
                                    fmt::format("void {} has no area", i),
                                    "either polygon, outside, track and width, or diameter and "
                                    "circles; and a line in its file"));
  }
  auto voids = Voids::make(std::move(all), written.margin);
  if (voids) return voids;
  Diagnostic problem = std::move(voids).error();
  problem.place = {file, 0, 0};
  return failure(std::move(problem));
}

}  // namespace panelcal::internal
