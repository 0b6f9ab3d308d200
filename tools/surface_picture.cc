// SPDX-License-Identifier: Apache-2.0
#include "panelcal/tools/surface_picture.h"

#include <cmath>

#include <fmt/format.h>

#include "panelcal/tools/report_text.h"

namespace panelcal::surface {
namespace {

using contours::ContourMap;
using Eigen::Vector2d;
using plan::Drawing;
using report::View;

/// Nodes along the longer side of what is drawn.
constexpr int kHeightNodes = 110;
constexpr int kSigmaNodes = 70;
constexpr int kHeightLevels = 8;
constexpr int kSigmaLevels = 5;
/// Of probes, red crosses have room for so many names.
constexpr std::size_t kMostNames = 12;

std::string cross(const Vector2d& at, double size, std::string_view css_class) {
  return fmt::format(
      "<path class=\"{0}\" d=\"M{1:.1f} {2:.1f}l{3:.1f} {3:.1f}m0 {4:.1f}l{4:.1f} {3:.1f}\"/>",
      css_class,
      at.x() - size,
      at.y() - size,
      2 * size,
      -2 * size);
}

std::string mark(const std::string& title, const std::string& shape) {
  return fmt::format("<g><title>{}</title>{}</g>\n", report::escaped(title), shape);
}

/// Probes that were left out, and places without a height.
std::string problems(const MadeMap& made, const View& view) {
  std::string out;
  const auto& outliers = made.stored.map.outliers();
  for (const SurfaceOutlier& outlier : outliers) {
    const Vector2d at = view.at(made.stored.points[outlier.i_point].place.in_mm());
    std::string shape = cross(at, 5, "wrong");
    if (outliers.size() <= kMostNames) {
      shape += fmt::format("<text class=\"wrong\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>",
                           at.x() + 9,
                           at.y() + 4,
                           report::fixed_signed(outlier.deviation.in_mm(), 3));
    }
    out += mark("left out: " + left_out_text(made.stored, outlier), shape);
  }
  for (const MissingProbe& missing : made.missing) {
    out += mark(missing.name + ": " + missing.reason,
                cross(view.at(missing.place.in_mm()), 4, "missing"));
  }
  return out;
}

ContourMap heights_map(const StoredMap& stored, const std::vector<Vector2d>& outline) {
  ContourMap out;
  out.id = "heights";
  out.title = "Height above the table, mm";
  out.unit = "mm";
  out.outline = outline;
  out.palette = contours::Palette::Heights;
  // The lattice reaches as far as heights are given; the corners beyond are cut off.
  out.field = contours::field_over(outline, kHeightNodes, [&](const auto& places) {
    std::vector<double> values;
    for (const auto& place : places) {
      values.push_back(stored.map.lattice().height_mm(place.in_mm()));
    }
    return values;
  });
  const auto [low, high] = std::ranges::minmax(out.field.values);
  out.levels = contours::round_levels(low, high, kHeightLevels);
  return out;
}

ContourMap sigma_map(const StoredMap& stored, const std::vector<Vector2d>& outline) {
  ContourMap out;
  out.id = "sigmas";
  out.title = "Sigma of the height, um";
  out.unit = "um";
  out.outline = outline;
  out.palette = contours::Palette::Sigmas;
  out.field = contours::field_over(outline, kSigmaNodes, [&](const auto& places) {
    std::vector<double> values;
    for (const HeightEstimate& height : stored.map.surface().at(places)) {
      values.push_back(std::hypot(height.sigma.in_um(), stored.map.lattice_error().in_um()));
    }
    return values;
  });
  const auto [low, high] = std::ranges::minmax(out.field.values);
  out.levels = contours::round_levels(low, high, kSigmaLevels);
  return out;
}

}  // namespace

std::vector<Vector2d> hull_of(const HeightMap& map) {
  std::vector<Vector2d> out;
  for (const auto& corner : map.hull()) out.push_back(corner.in_mm());
  return out;
}

std::string hatching(const StoredMap& stored, const View& view, const std::string& id) {
  const HeightMap& map = stored.map;
  const std::vector<Vector2d> hull = hull_of(map);
  const std::string inner = contours::polygon_path(view, hull);
  const std::string outer = contours::polygon_path(
      view, contours::widened(hull, map.options().max_extrapolation.in_mm()));
  const Vector2d reach = view.px_per_mm() * *map.options().reach_mm;
  std::string vouched;
  for (const std::size_t i : map.kept()) {
    const Vector2d corner = view.at(stored.points[i].place.in_mm()) - reach;
    vouched += fmt::format("M{:.1f} {:.1f}h{:.1f}v{:.1f}h{:.1f}z",
                           corner.x(),
                           corner.y(),
                           2 * reach.x(),
                           2 * reach.y(),
                           -2 * reach.x());
  }
  return fmt::format(
      R"svg(<pattern id="{0}-out" width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)"><path class="hatch" d="M3 0v6"/></pattern>
<pattern id="{0}-gap" width="5" height="5" patternUnits="userSpaceOnUse" patternTransform="rotate(-45)"><path class="dense" d="M2.5 0v5"/></pattern>
<mask id="{0}-gaps"><path style="fill:#fff" d="{1}"/><path style="fill:#000" d="{2}"/></mask>
<path style="fill:url(#{0}-out);fill-rule:evenodd" d="{1}{3}"/>
<path style="fill:url(#{0}-gap)" mask="url(#{0}-gaps)" d="{1}"/>
<path class="hull" d="{1}"/>
)svg",
      id,
      inner,
      vouched,
      outer);
}

std::string probe_dots(const StoredMap& stored, const View& view, std::string_view css_class) {
  std::string out;
  for (const std::size_t i : stored.map.kept()) {
    const ProbePoint& probe = stored.points[i];
    const Vector2d at = view.at(probe.place.in_mm());
    out += mark(fmt::format("{}: {:.4f} mm", name_of(probe), probe.measured.height.in_mm()),
                fmt::format("<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"/>",
                            css_class,
                            at.x(),
                            at.y(),
                            stored.map.kept().size() > 150 ? 1.8 : 3));
  }
  return out;
}

std::vector<Drawing> map_drawings(const MadeMap& made) {
  const StoredMap& stored = made.stored;
  const std::vector<Vector2d> outline =
      contours::widened(hull_of(stored.map), stored.map.options().max_extrapolation.in_mm());
  const View view = contours::view_of(outline);
  std::vector<Drawing> out;
  for (ContourMap map : {heights_map(stored, outline), sigma_map(stored, outline)}) {
    for (const SurfaceOutlier& outlier : stored.map.outliers()) {
      map.marked.push_back(stored.points[outlier.i_point].place.in_mm());
    }
    out.push_back(contours::contour_drawing(
        map,
        view,
        hatching(stored, view, map.id) + probe_dots(stored, view, "probe") + problems(made, view)));
  }
  return out;
}

std::string map_svg(const MadeMap& made, const Provenance& provenance) {
  return contours::sheet_svg("Surface map " + made.file, map_drawings(made), provenance);
}

}  // namespace panelcal::surface
