// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/picture.h"

#include <cmath>

#include "tools/figures/text.h"
#include "tools/surface/blanks.h"
#include "tools/surface/shapes.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

using contours::ContourMap;
using Eigen::Vector2d;
using report::Drawing;
using report::View;

/// Nodes along the longer side of what is drawn.
constexpr int kHeightNodes = 110;
constexpr int kSigmaNodes = 70;
constexpr int kHeightLevels = 8;
constexpr int kSigmaLevels = 5;
/// Borders of zones are shown this far beyond the map, by its size.
constexpr double kNearBorder = 0.3;
/// Of probes, red crosses have room for this number of names.
constexpr std::size_t kMostNames = 12;

std::string diagonal_cross(const Vector2d& at, double size, std::string_view css_class) {
  return fmt::format(
      "<path class=\"{0}\" d=\"M{1:.1f} {2:.1f}l{3:.1f} {3:.1f}m0 {4:.1f}l{4:.1f} {3:.1f}\"/>",
      css_class,
      at.x() - size,
      at.y() - size,
      2 * size,
      -2 * size);
}

std::string titled_mark(const std::string& title, const std::string& shape) {
  return fmt::format("<g><title>{}</title>{}</g>\n", report::escaped(title), shape);
}

/// Probes that were left out or are not used, and places without a height.
std::string problems(const MadeMap& made, const MadeZone& zone, const View& view) {
  std::string out;
  const auto& outliers = zone.stored.map.outliers();
  for (const SurfaceOutlier& outlier : outliers) {
    const Vector2d at = view.at(zone.stored.points[outlier.i_point].place.in_mm());
    std::string shape = diagonal_cross(at, 5, "wrong");
    if (outliers.size() <= kMostNames) {
      shape += fmt::format("<text class=\"wrong\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>",
                           at.x() + 9,
                           at.y() + 4,
                           report::fixed_signed(outlier.deviation.in_mm(), 3));
    }
    out += titled_mark("left out: " + left_out_text(zone.stored, outlier), shape);
  }
  for (const UnusedProbe& unused : made.stored.map.unused()) {
    const Vector2d at = view.at(made.stored.points[unused.i_point].place.in_mm());
    out += titled_mark("not used: " + unused_text(made.stored, unused),
                       diagonal_cross(at, 4, "missing"));
  }
  for (const MissingProbe& missing : made.missing) {
    out += titled_mark(missing.name + ": " + missing.reason,
                       diagonal_cross(view.at(missing.place.in_mm()), 4, "missing"));
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
  return out;
}

/// An outline with its zone's border, as far as that is near.
std::vector<Vector2d> with_border(std::vector<Vector2d> outline,
                                  const ZonedMap& map,
                                  std::size_t i_zone) {
  if (map.zones().empty()) return outline;
  Vector2d low_mm = outline.front(), high_mm = low_mm;
  for (const Vector2d& corner_mm : outline) {
    low_mm = low_mm.cwiseMin(corner_mm);
    high_mm = high_mm.cwiseMax(corner_mm);
  }
  const Vector2d near_mm = kNearBorder * (high_mm - low_mm);
  const AreaBox box = box_of(map.zones()[i_zone].area);
  for (const Vector2d& corner_mm : {box.low_mm, box.high_mm}) {
    outline.push_back(corner_mm.cwiseMax(low_mm - near_mm).cwiseMin(high_mm + near_mm));
  }
  return outline;
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
    out += titled_mark(fmt::format("{}: {:.4f} mm", name_of(probe), probe.measured.height.in_mm()),
                       fmt::format("<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"/>",
                                   css_class,
                                   at.x(),
                                   at.y(),
                                   stored.map.kept().size() > 150 ? 1.8 : 3));
  }
  return out;
}

std::vector<Drawing> zone_drawings(const MadeMap& made, std::size_t i_zone) {
  const MadeZone& zone = made.zones[i_zone];
  const ZonedMap& zoned = made.stored.map;
  const StoredMap& stored = zone.stored;
  const std::vector<Vector2d> outline =
      contours::widened(hull_of(stored.map), stored.map.options().max_extrapolation.in_mm());
  const View view = contours::view_of(with_border(outline, zoned, i_zone));
  std::vector<Drawing> out;
  for (ContourMap map : {heights_map(stored, outline), sigma_map(stored, outline)}) {
    if (made.has_zones()) {
      map.id += fmt::format("-{}", i_zone);
      map.title = fmt::format("{}: {}", zone.name, map.title);
    }
    for (const SurfaceOutlier& outlier : stored.map.outliers()) {
      map.marked.push_back(stored.points[outlier.i_point].place.in_mm());
    }
    map.is_covered = [&](const Vector2d& p_mm) {
      return is_blank(zoned, i_zone, position_mm<frame::Nominal>(p_mm));
    };
    contours::set_levels(map,
                         map.palette == contours::Palette::Heights ? kHeightLevels : kSigmaLevels);
    out.push_back(contours::contour_drawing(
        map,
        view,
        hatching(stored, view, map.id) + blanks(zoned, i_zone, view) +
            probe_dots(stored, view, "probe") + problems(made, zone, view)));
  }
  return out;
}

}  // namespace panelcal::surface
