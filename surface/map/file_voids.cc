// SPDX-License-Identifier: Apache-2.0
#include "surface/map/file_voids.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <limits>
#include <string_view>
#include <utility>

#include "surface/map/file_surface.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using nlohmann::json;
using Corners = std::vector<Position<frame::Nominal>>;

constexpr int kMaxVoidInt = std::numeric_limits<int>::max();

std::string corners_text(const Corners& corners) {
  std::string out;
  for (const auto& corner : corners) {
    fmt::format_to(std::back_inserter(out),
                   "{}[{}, {}]",
                   out.empty() ? "" : ", ",
                   corner.in_mm().x(),
                   corner.in_mm().y());
  }
  return "[" + out + "]";
}

/// The keys of an area, without braces.
std::string keys_text(const Circle& circle) {
  return fmt::format(R"("center": [{}, {}], "diameter": {})",
                     circle.center.in_mm().x(),
                     circle.center.in_mm().y(),
                     2 * circle.radius.in_mm());
}

std::string keys_text(const Polygon& polygon) {
  return "\"polygon\": " + corners_text(polygon.corners);
}

std::string keys_text(const Track& track) {
  return fmt::format(
      R"("width": {}, "track": {})", track.width.in_mm(), corners_text(track.points));
}

std::string keys_text(const Outside& outside) {
  return "\"outside\": " + corners_text(outside.panel.corners);
}

Expected<Corners> read_corners(const StrictObject& object,
                               std::string_view key,
                               const std::string& file) {
  const json& list = object.member(key);
  const auto bad = [&] {
    return failure(map_file_problem(
        file, fmt::format("{} is no list of places", quoted(key)), "[[x, y], ...]"));
  };
  if (!list.is_array()) return bad();
  Corners out;
  for (const json& element : list) {
    if (!element.is_array() || element.size() != 2 || !element[0].is_number() ||
        !element[1].is_number()) {
      return bad();
    }
    out.push_back(position_mm<frame::Nominal>(element[0].get<double>(), element[1].get<double>()));
  }
  return out;
}

/// Form in which an area is written, known by its first key, which only one form has.
struct Kind {
  std::string_view key;
  std::string_view other;  ///< that it has as well; empty: none
};
constexpr std::array<Kind, 4> kKinds = {
    {{"polygon", ""}, {"center", "diameter"}, {"track", "width"}, {"outside", ""}}};
constexpr Kind kCircles = {"circles", "diameter"};

/// The object with the keys of its kind and `others`; and the kind.
///
/// Fails  measurement-file: none of these kinds; other keys
Expected<std::pair<StrictObject, Kind>> read_kind(const json& value,
                                                  const std::string& name,
                                                  std::span<const Kind> kinds,
                                                  std::vector<std::string_view> keys,
                                                  const std::string& file) {
  const auto kind = std::ranges::find_if(
      kinds, [&](const Kind& one) { return value.is_object() && value.contains(one.key); });
  if (kind == kinds.end()) {
    std::vector<std::string_view> words;
    for (const Kind& one : kinds) words.push_back(one.key);
    return failure(map_file_problem(
        file, name + " has no area", fmt::format("one of {}", fmt::join(words, ", "))));
  }
  keys.push_back(kind->key);
  if (!kind->other.empty()) keys.push_back(kind->other);
  PANELCAL_TRY(StrictObject object, StrictObject::make(value, name, keys, kMapFileCode, file));
  return std::pair(std::move(object), *kind);
}

Expected<Area> read_area(const StrictObject& object, const Kind& kind, const std::string& file) {
  if (kind.key == "center") {
    PANELCAL_TRY(const auto center_mm, object.numbers("center", 2));
    PANELCAL_TRY(const double diameter_mm, object.number("diameter"));
    return Circle{position_mm<frame::Nominal>(center_mm[0], center_mm[1]), mm(diameter_mm / 2)};
  }
  PANELCAL_TRY(Corners corners, read_corners(object, kind.key, file));
  if (kind.key == "polygon") return Polygon{std::move(corners)};
  if (kind.key == "outside") return Outside{{std::move(corners)}};
  PANELCAL_TRY(const double width_mm, object.number("width"));
  return Track{std::move(corners), mm(width_mm)};
}

/// Of a circle that may share its element with the next ones.
const Circle* circle_of(const Void& hole) {
  return std::get_if<Circle>(&hole.area);
}

bool share_an_element(const Void& a, const Void& b) {
  return circle_of(a) != nullptr && circle_of(b) != nullptr && a.name == b.name &&
         a.from.file == b.from.file && circle_of(a)->radius == circle_of(b)->radius;
}

Expected<void> read_circles(const StrictObject& object,
                            const Void& of_all,
                            std::vector<Void>& out,
                            const std::string& file) {
  PANELCAL_TRY(const double diameter_mm, object.number("diameter"));
  const auto bad = [&] {
    return failure(
        map_file_problem(file, "\"circles\" is no list of circles", "[[x, y, line], ...]"));
  };
  const json& list = object.member("circles");
  if (!list.is_array()) return bad();
  for (const json& element : list) {
    if (!element.is_array() || element.size() != 3 || !element[0].is_number() ||
        !element[1].is_number() || !element[2].is_number_unsigned() ||
        element[2].get<std::uint64_t>() > kMaxVoidInt) {
      return bad();
    }
    Void hole = of_all;
    hole.area =
        Circle{position_mm<frame::Nominal>(element[0].get<double>(), element[1].get<double>()),
               mm(diameter_mm / 2)};
    hole.from.line = element[2].get<int>();
    out.push_back(std::move(hole));
  }
  return {};
}

Expected<void> read_void(const json& value, std::vector<Void>& out, const std::string& file) {
  constexpr std::array<Kind, 4> kVoidKinds = {kCircles, kKinds[0], kKinds[2], kKinds[3]};
  std::vector<std::string_view> keys = {"name", "file"};
  if (value.is_object() && !value.contains(kCircles.key)) keys.push_back("line");
  PANELCAL_TRY(const auto read,
               read_kind(value, fmt::format("void {}", out.size()), kVoidKinds, keys, file));
  const auto& [object, kind] = read;
  Void one;
  PANELCAL_TRY(one.name, object.text("name"));
  PANELCAL_TRY(one.from.file, object.text("file"));
  if (kind.key == kCircles.key) return read_circles(object, one, out, file);
  PANELCAL_TRY(one.from.line, object.integer("line", 0, kMaxVoidInt));
  PANELCAL_TRY(one.area, read_area(object, kind, file));
  out.push_back(std::move(one));
  return {};
}

}  // namespace

std::string area_text(const Area& area) {
  return "{" + std::visit([](const auto& shape) { return keys_text(shape); }, area) + "}";
}

Expected<Area> read_zone_area(const json& value, const std::string& name, const std::string& file) {
  constexpr std::array<Kind, 2> kZoneKinds = {kKinds[0], kKinds[1]};
  PANELCAL_TRY(const auto read, read_kind(value, name, kZoneKinds, {}, file));
  PANELCAL_TRY(Area area, read_area(read.first, read.second, file));
  PANELCAL_CHECK(check_area(area, name, {file, 0, 0}));
  return area;
}

std::vector<std::string> void_texts(std::span<const Void> voids) {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < voids.size();) {
    const Void& first = voids[i];
    std::string text = fmt::format(
        R"({{"name": {}, "file": {}, )", json_text(first.name), json_text(first.from.file));
    if (circle_of(first) == nullptr) {
      text +=
          fmt::format(R"("line": {}, {}}})",
                      first.from.line,
                      std::visit([](const auto& shape) { return keys_text(shape); }, first.area));
      ++i;
    } else {
      text += fmt::format(R"("diameter": {}, "circles": [)", 2 * circle_of(first)->radius.in_mm());
      for (const std::size_t begin = i; i < voids.size() && share_an_element(first, voids[i]);
           ++i) {
        const Eigen::Vector2d& at_mm = circle_of(voids[i])->center.in_mm();
        fmt::format_to(std::back_inserter(text),
                       "{}[{}, {}, {}]",
                       i > begin ? ", " : "",
                       at_mm.x(),
                       at_mm.y(),
                       voids[i].from.line);
      }
      text += "]}";
    }
    out.push_back(std::move(text));
  }
  return out;
}

Expected<Voids> read_voids(const StrictObject& top, const std::string& file) {
  PANELCAL_TRY(const double margin_mm, top.number("margin"));
  const json& list = top.member("voids");
  if (!list.is_array()) {
    return failure(map_file_problem(file, "\"voids\" is no array", "[{...}, ...]"));
  }
  std::vector<Void> all;
  for (const json& element : list) PANELCAL_CHECK(read_void(element, all, file));
  auto voids = Voids::make(std::move(all), mm(margin_mm));
  if (voids) return voids;
  Diagnostic problem = std::move(voids).error();
  problem.place = {file, 0, 0};
  return failure(std::move(problem));
}

}  // namespace panelcal::internal
