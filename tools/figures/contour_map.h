// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/frames.h"
#include "tools/figures/contours.h"
#include "tools/figures/drawing.h"
#include "tools/figures/svg.h"

namespace panelcal::contours {

/// Colours from the lowest band to the highest, in equal steps.
enum class Palette : std::uint8_t {
  Heights,      ///< blue, sand, brown
  Sigmas,       ///< pale, orange, red
  Differences,  ///< blue below zero, red above; needs levels on both sides of it
};

/// A field in bands of colour with lines between them, within an outline.
struct ContourMap {
  std::string id;  ///< of this map among those of a page, for what SVG refers to
  std::string title;
  std::string unit;
  Field field;
  std::vector<double> levels;  ///< rising
  Palette palette = Palette::Heights;
  std::vector<Eigen::Vector2d> outline;  ///< corners; mm, as the field's x and y
  std::vector<Eigen::Vector2d> marked;   ///< places of marks that labels keep off
  /// True if marks cover a place; empty: none does. Labels keep off.
  std::function<bool(const Eigen::Vector2d&)> is_covered = {};
};

/// Styles of the classes that these drawings use; they are on white paper, whatever surrounds them.
extern const std::string_view kContourStyle;

/// Gives a map at least n round levels of what its field has within the outline, but for what is
/// covered. None if that is all one height.
void set_levels(ContourMap& map, int n);

/// The view of a map of this outline.
report::View view_of(const std::vector<Eigen::Vector2d>& outline);

/// The map with axes and a strip of its colours; `marks` are drawn above the bands and below the
/// labels, as far as the frame reaches.
report::Drawing contour_drawing(const ContourMap& map,
                                const report::View& view,
                                const std::string& marks);

/// Path data of all that the frame holds.
std::string frame_path(const report::View& view);

/// Path data of a closed polygon.
std::string polygon_path(const report::View& view, const std::vector<Eigen::Vector2d>& corners);

/// A convex outline, counter-clockwise, moved outwards, with round corners.
std::vector<Eigen::Vector2d> widened(const std::vector<Eigen::Vector2d>& corners, double by_mm);

/// A field of `value(place_mm)`s over the rectangle of an outline.
template <class Values>
Field field_over(const std::vector<Eigen::Vector2d>& outline, int n_along, const Values& values) {
  Eigen::Vector2d low = outline.front(), high = low;
  for (const Eigen::Vector2d& corner : outline) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  const Eigen::Vector2d size = high - low;
  Field out;
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double>& nodes = axis == 0 ? out.x : out.y;
    const int n = std::max(2, static_cast<int>(n_along * size[axis] / size.maxCoeff()));
    for (int i = 0; i <= n; ++i) nodes.push_back(low[axis] + size[axis] * i / n);
  }
  std::vector<Position<frame::Nominal>> places;
  for (const double y : out.y) {
    for (const double x : out.x) places.push_back(position_mm<frame::Nominal>(x, y));
  }
  out.values = values(places);
  return out;
}

/// Rows of drawings side by side on one sheet.
std::string sheet_svg(std::string_view title,
                      const std::vector<std::vector<report::Drawing>>& rows,
                      const std::vector<std::pair<std::string, std::string>>& provenance);

/// A drawing as a picture of its own within a page.
std::string inline_svg(const report::Drawing& drawing, std::string_view label);

}  // namespace panelcal::contours
