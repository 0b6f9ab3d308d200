// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/difference.h"

#include <algorithm>
#include <cmath>

#include "calib/base/json/json_string.h"
#include "tools/figures/text.h"
#include "tools/surface/picture.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

constexpr int kDifferenceNodes = 110;
constexpr int kDifferenceLevels = 9;

std::string difference_line(std::string_view what, std::string_view text) {
  return fmt::format("{:<11}{}\n", what, text);
}

std::string with_sigma(const Measured& measured, std::string_view unit) {
  // Two digits of sigma.
  const int n_decimals =
      std::clamp(1 - static_cast<int>(std::floor(std::log10(measured.sigma))), 0, 6);
  return fmt::format(
      "{:+.{}f} +- {:.{}f} {}", measured.value, n_decimals, measured.sigma, n_decimals, unit);
}

std::string difference_chance_text(double chance) {
  return chance < 1e-9 ? "below 1e-9" : fmt::format("{:.2g}", chance);
}

std::string judged(const DifferencePart& part) {
  return fmt::format("{} (chance {})",
                     part.chance < kSignificant ? "changed" : "no more than scatter",
                     difference_chance_text(part.chance));
}

std::string part_json(const DifferencePart& part) {
  return fmt::format(R"({{"chi_square":{:.9g},"dof":{},"chance":{:.9g}}})",
                     part.chi_square,
                     part.degrees_of_freedom,
                     part.chance);
}

std::string measured_json(const Measured& measured) {
  return fmt::format(R"({{"value":{:.9g},"sigma":{:.9g}}})", measured.value, measured.sigma);
}

std::string difference_point_json(const Eigen::Vector2d& p_mm) {
  return fmt::format("[{:.9g},{:.9g}]", p_mm.x(), p_mm.y());
}

}  // namespace

std::string difference_text(const ComparedMaps& maps) {
  const MapDifference& d = maps.difference;
  const bool stands_in = d.model != maps.before.map.surface().model();
  std::string out = difference_line(
      "compared",
      fmt::format(
          "{} of {} with the prediction of {}{}{}",
          amount(d.n_probes, "probe"),
          maps.after_file,
          maps.before_file,
          stands_in ? fmt::format(", as a {} of its probes", name_of(d.model)) : "",
          d.n_outside > 0 ? fmt::format("; {} more stand outside of it", d.n_outside) : ""));
  out += difference_line(
      "panel",
      d.all.chance < kSignificant
          ? fmt::format("changed: by scatter alone it would look so with a chance of {}",
                        difference_chance_text(d.all.chance))
          : fmt::format("not seen to change: scatter alone does as much with a chance of {}",
                        difference_chance_text(d.all.chance)));
  out += difference_line("offset",
                         fmt::format("{} at ({:.1f}, {:.1f}); {}",
                                     with_sigma(d.offset_um, "um"),
                                     d.center_mm.x(),
                                     d.center_mm.y(),
                                     judged(d.offset)));
  out += difference_line("tilt",
                         fmt::format("{} along x, {} along y; {}",
                                     with_sigma(d.tilt_x, "um/m"),
                                     with_sigma(d.tilt_y, "um/m"),
                                     judged(d.tilt)));
  if (d.bow) {
    out += difference_line("bow",
                           fmt::format("{} along x, {} along y, twist {}; {}",
                                       with_sigma(*d.bow_x_um, "um"),
                                       with_sigma(*d.bow_y_um, "um"),
                                       with_sigma(*d.twist_um, "um"),
                                       judged(*d.bow)));
  } else {
    out += difference_line("bow", "not determined by this number of probes");
  }
  if (d.rest) out += difference_line("rest", "the rest of the difference: " + judged(*d.rest));
  out += difference_line("rms", um_text(d.rms) + " over what both maps probed");
  return out + difference_line("greatest",
                               fmt::format("{:+.1f} um +- {} at {}",
                                           d.greatest.in_um(),
                                           um_text(d.greatest_sigma),
                                           place_text(d.greatest_at)));
}

std::string difference_json(const ComparedMaps& maps) {
  const MapDifference& d = maps.difference;
  std::string out = "{\"before\":";
  append_json_string(out, maps.before_file);
  out += ",\"after\":";
  append_json_string(out, maps.after_file);
  out += fmt::format(
      R"(,"changed":{},"model":"{}","probes":{},"outside":{},"center":{},"half":{},"all":{},"offset":{},"tilt":{},)"
      R"("offset_um":{},"tilt_x_um_m":{},"tilt_y_um_m":{})",
      d.all.chance < kSignificant,
      word(d.model),
      d.n_probes,
      d.n_outside,
      difference_point_json(d.center_mm),
      difference_point_json(d.half_mm),
      part_json(d.all),
      part_json(d.offset),
      part_json(d.tilt),
      measured_json(d.offset_um),
      measured_json(d.tilt_x),
      measured_json(d.tilt_y));
  if (d.bow) {
    out += fmt::format(R"(,"bow":{},"bow_x_um":{},"bow_y_um":{},"twist_um":{})",
                       part_json(*d.bow),
                       measured_json(*d.bow_x_um),
                       measured_json(*d.bow_y_um),
                       measured_json(*d.twist_um));
  }
  if (d.rest) out += ",\"rest\":" + part_json(*d.rest);
  return out + fmt::format(
                   ",\"rms_um\":{:.9g},\"greatest_um\":{:.9g},\"greatest_sigma_um\":{:.9g},"
                   "\"greatest_at\":{}}}\n",
                   d.rms.in_um(),
                   d.greatest.in_um(),
                   d.greatest_sigma.in_um(),
                   difference_point_json(d.greatest_at.in_mm()));
}

std::string difference_svg(const ComparedMaps& maps, const Provenance& provenance) {
  contours::ContourMap map;
  map.id = "difference";
  map.title = "Later minus earlier, um; ring: greatest";
  map.unit = "um";
  map.palette = contours::Palette::Differences;
  map.outline = maps.difference.common_mm;
  map.field = contours::field_over(map.outline, kDifferenceNodes, [&](const auto& places) {
    std::vector<double> values;
    for (const auto& place : places) {
      const double was_mm = maps.before.map.lattice().height_mm(place.in_mm());
      values.push_back(1e3 * (maps.after.map.lattice().height_mm(place.in_mm()) - was_mm));
    }
    return values;
  });
  contours::set_levels(map, kDifferenceLevels);
  const report::View view = contours::view_of(map.outline);
  const Eigen::Vector2d at = view.at(maps.difference.greatest_at.in_mm());
  // On a white one: where the difference is greatest the map may be as red as anything.
  std::string greatest;
  for (const std::string_view css_class : {"halo", "ring"}) {
    greatest += fmt::format(
        "<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"9\"/>\n", css_class, at.x(), at.y());
  }
  return contours::sheet_svg(
      fmt::format("From {} to {}", maps.before_file, maps.after_file),
      {{contours::contour_drawing(map,
                                  view,
                                  probe_dots(maps.before, view, "old") +
                                      probe_dots(maps.after, view, "probe") + greatest)}},
      provenance);
}

}  // namespace panelcal::surface
