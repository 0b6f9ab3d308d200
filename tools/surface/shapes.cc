// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <variant>

namespace panelcal::surface {
namespace {

using facts::Json;

constexpr int kBorderCorners = 64;
/// Along the longer side: heights between nodes are straight for the eye.
constexpr int kPictureNodes = 96;

}  // namespace

Json column(std::span<const double> values) {
  if (values.size() > kMostPlainRows) {
    return facts::packed(std::vector<float>(values.begin(), values.end()));
  }
  Json out = Json::array();
  for (const double value : values) out.push_back(facts::number(value));
  return out;
}

Json column(std::span<const std::uint32_t> values) {
  if (values.size() > kMostPlainRows) return facts::packed(values);
  return Json(std::vector<std::uint32_t>(values.begin(), values.end()));
}

Json word_column(std::span<const std::string> values) {
  std::map<std::string, std::uint32_t> known;
  Json words = Json::array();
  std::vector<std::uint32_t> index;
  for (const std::string& value : values) {
    const auto [at, is_new] = known.emplace(value, static_cast<std::uint32_t>(known.size()));
    if (is_new) words.push_back(value);
    index.push_back(at->second);
  }
  Json out = {{"words", std::move(words)}};
  out["index"] = column(index);
  return out;
}

Json corners(std::span<const Position<frame::Nominal>> places) {
  Json out = Json::array();
  for (const auto& place : places) out.push_back(facts::point(place.in_mm()));
  return out;
}

Json border(const Area& area) {
  if (const auto* polygon = std::get_if<Polygon>(&area)) return corners(polygon->corners);
  const auto* circle = std::get_if<Circle>(&area);
  if (circle == nullptr) return Json::array();
  std::vector<Position<frame::Nominal>> around;
  for (int k = 0; k < kBorderCorners; ++k) {
    const double angle_rad = 2 * std::numbers::pi * k / kBorderCorners;
    around.push_back(circle->center +
                     displacement_mm<frame::Nominal>(circle->radius.in_mm() * std::cos(angle_rad),
                                                     circle->radius.in_mm() * std::sin(angle_rad)));
  }
  return corners(around);
}

Json voids_facts(const Voids& voids) {
  std::vector<double> x_mm, y_mm, radius_mm;
  Json tracks = Json::array(), polygons = Json::array(), outsides = Json::array();
  for (const Void& one : voids.all()) {
    if (const auto* circle = std::get_if<Circle>(&one.area)) {
      x_mm.push_back(circle->center.in_mm().x());
      y_mm.push_back(circle->center.in_mm().y());
      radius_mm.push_back(circle->radius.in_mm());
    } else if (const auto* track = std::get_if<Track>(&one.area)) {
      tracks.push_back({{"width_mm", track->width.in_mm()}, {"points_mm", corners(track->points)}});
    } else if (const auto* polygon = std::get_if<Polygon>(&one.area)) {
      polygons.push_back(corners(polygon->corners));
    } else if (const auto* outside = std::get_if<Outside>(&one.area)) {
      outsides.push_back(corners(outside->panel.corners));
    }
  }
  Json out = {{"count", voids.all().size()}, {"margin_mm", voids.margin().in_mm()}};
  out["circles"] = {
      {"x_mm", column(x_mm)}, {"y_mm", column(y_mm)}, {"radius_mm", column(radius_mm)}};
  out["tracks"] = std::move(tracks);
  out["polygons_mm"] = std::move(polygons);
  out["panel_edges_mm"] = std::move(outsides);
  return out;
}

bool is_blank(const ZonedMap& map, std::size_t i_zone, const Position<frame::Nominal>& place) {
  return map.zone_at(place) != i_zone || map.voids().at(place) != nullptr;
}

PictureGrid::PictureGrid(std::span<const Eigen::Vector2d> area, Length margin) {
  low_mm_ = area.front();
  Eigen::Vector2d high_mm = low_mm_;
  for (const Eigen::Vector2d& corner_mm : area) {
    low_mm_ = low_mm_.cwiseMin(corner_mm);
    high_mm = high_mm.cwiseMax(corner_mm);
  }
  low_mm_.array() -= margin.in_mm();
  high_mm.array() += margin.in_mm();
  const Eigen::Vector2d size_mm = high_mm - low_mm_;
  const double step_mm = size_mm.maxCoeff() / (kPictureNodes - 1);
  n_columns_ = 1 + std::max(1, static_cast<int>(std::lround(size_mm.x() / step_mm)));
  n_rows_ = 1 + std::max(1, static_cast<int>(std::lround(size_mm.y() / step_mm)));
  step_mm_ = {size_mm.x() / (n_columns_ - 1), size_mm.y() / (n_rows_ - 1)};
}

std::vector<Position<frame::Nominal>> PictureGrid::nodes() const {
  std::vector<Position<frame::Nominal>> out;
  for (int row = 0; row < n_rows_; ++row) {
    for (int column = 0; column < n_columns_; ++column) {
      out.push_back(position_mm<frame::Nominal>(low_mm_.x() + column * step_mm_.x(),
                                                low_mm_.y() + row * step_mm_.y()));
    }
  }
  return out;
}

Json PictureGrid::facts() const {
  return {{"first_mm", facts::point(low_mm_)},
          {"step_mm", facts::point(step_mm_)},
          {"columns", n_columns_},
          {"rows", n_rows_}};
}

}  // namespace panelcal::surface
