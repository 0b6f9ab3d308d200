// SPDX-License-Identifier: Apache-2.0
#include "tools/report/surface/depth_map.h"

#include <algorithm>
#include <vector>

#include "tools/figures/contour_map.h"
#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

constexpr int kDepthNodes = 90;  // along the longer side
constexpr int kDepthLevels = 8;

contours::ContourMap heights_of(const HeightMap& map, std::size_t i_picture) {
  contours::ContourMap out;
  out.id = fmt::format("depth{}", i_picture);
  out.title = "Height above the table, mm";
  out.unit = "mm";
  for (const auto& corner : map.hull()) out.outline.push_back(corner.in_mm());
  out.field = contours::field_over(out.outline, kDepthNodes, [&](const auto& places) {
    std::vector<double> heights_mm;
    for (const auto& place : places) {
      heights_mm.push_back(map.lattice().height_mm(place.in_mm()));
    }
    return heights_mm;
  });
  const auto [low, high] = std::ranges::minmax(out.field.values);
  out.levels = contours::round_levels(low, high, kDepthLevels);
  return out;
}

/// A cross where each tool's likeliest depth to break its tolerance is, if that is in the zone.
std::string worst_marks(const DepthVerdict& verdict,
                        std::size_t axis,
                        std::size_t i_zone,
                        const View& view,
                        std::vector<Eigen::Vector2d>& places_mm) {
  constexpr double kArm_px = 5;
  std::string out;
  for (const auto& [number, tool] : verdict.by_tool()) {
    if (tool.places.n_judged == 0 || tool.worst.error.axis.value_or(0) != axis) continue;
    if (verdict.errors().maps()[axis]->zone_at(tool.worst.nominal) != i_zone) continue;
    places_mm.push_back(tool.worst.nominal.in_mm());
    const Eigen::Vector2d at = view.at(places_mm.back());
    out += fmt::format(
        "<g><title>{}</title><path class=\"wrong\" d=\"M{:.1f} {:.1f}l{:.1f} {:.1f}m0 "
        "{:.1f}l{:.1f} "
        "{:.1f}\"/><text class=\"wrong\" x=\"{:.1f}\" y=\"{:.1f}\">T{}</text></g>\n",
        escaped(place_text(tool.worst.nominal, tool.worst.path)),
        at.x() - kArm_px,
        at.y() - kArm_px,
        2 * kArm_px,
        2 * kArm_px,
        -2 * kArm_px,
        -2 * kArm_px,
        2 * kArm_px,
        at.x() + 2 * kArm_px,
        at.y() + kArm_px,
        number);
  }
  return out;
}

bool has_map(const DepthVerdict& verdict) {
  return std::ranges::any_of(verdict.errors().maps(),
                             [](const Expected<ZonedMap>& map) { return map.has_value(); });
}

}  // namespace

std::string_view depth_map_style(const DepthVerdict* verdict) {
  return verdict != nullptr && has_map(*verdict) ? contours::kContourStyle : "";
}

std::string depth_map_figures(const DepthVerdict& verdict) {
  if (!has_map(verdict)) return {};
  const auto maps = verdict.errors().maps();
  std::string figures;
  std::size_t n_figures = 0;
  for (std::size_t axis = 0; axis < maps.size(); ++axis) {
    if (!maps[axis]) continue;
    for (std::size_t i_zone = 0; i_zone < maps[axis]->maps().size(); ++i_zone) {
      const HeightMap& map = maps[axis]->map(i_zone);
      contours::ContourMap picture = heights_of(map, n_figures++);
      // Heights are believed so far outside, and worst places may lie there.
      const View view = contours::view_of(
          contours::widened(picture.outline, map.options().max_extrapolation.in_mm()));
      const std::string marks = worst_marks(verdict, axis, i_zone, view, picture.marked);
      const auto zones = maps[axis]->zones();
      figures += "<figure>" +
                 contours::inline_svg(contours::contour_drawing(picture, view, marks),
                                      "The surface of the board") +
                 fmt::format(
                     "<figcaption>{}{}The surface that depths are judged by, within what was "
                     "probed; crosses are where each tool is likeliest to be too shallow or too "
                     "deep.</figcaption></figure>\n",
                     maps.size() == 1 ? "" : fmt::format("Z axis {}. ", axis),
                     zones.empty() ? "" : fmt::format("Zone {}. ", escaped(zones[i_zone].name)));
    }
  }
  return fmt::format(
      "<div class=\"figures{}\">{}</div>\n", n_figures == 1 ? " single" : "", figures);
}

}  // namespace panelcal::report
