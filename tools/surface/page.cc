// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>
#include <string_view>

#include "tools/figures/style.h"
#include "tools/figures/text.h"
#include "tools/surface/picture.h"
#include <fmt/format.h>

namespace panelcal::surface {
namespace {

using report::escaped;

constexpr std::string_view kSurfacePageStyle = R"css(
.maps{display:flex;flex-wrap:wrap;gap:16px}.maps>svg{flex:1 1 420px;min-width:0;height:auto}
)css";

std::string zone_tile(std::string_view name, std::string_view value, std::string_view note) {
  return fmt::format("<div><dt>{}</dt><dd>{}<small>{}</small></dd></div>\n",
                     escaped(name),
                     escaped(value),
                     escaped(note));
}

std::string zone_tiles(const MadeZone& made) {
  const MapFacts& facts = made.facts;
  const HeightMap& map = made.stored.map;
  return "<dl class=\"tiles\">\n" +
         zone_tile(
             "heights",
             fmt::format(
                 "{:.3f} to {:.3f} mm", facts.lowest.value.in_mm(), facts.highest.value.in_mm()),
             "a range of " + um_text(facts.highest.value - facts.lowest.value)) +
         zone_tile("worst sigma",
                   um_text(facts.worst_sigma.value),
                   fmt::format("at {}; usually {}",
                               place_text(facts.worst_sigma.at),
                               um_text(facts.usual_sigma))) +
         zone_tile("residuals",
                   um_text(facts.residual_rms),
                   "rms; stated sigma of the probes " + um_text(facts.stated_rms)) +
         zone_tile("left out",
                   amount(map.outliers().size(), "probe"),
                   fmt::format("of {}", made.stored.points.size())) +
         zone_tile("filled",
                   fmt::format("{:.1f} %", 100 * facts.filled_share()),
                   amount(facts.filled.size(), "gap") + " between the probes") +
         zone_tile("lattice", um_text(map.lattice_error()), "the most that it is off the surface") +
         "</dl>\n";
}

std::string zone_cell(std::string_view text, bool is_number = true) {
  return fmt::format("<td{}>{}</td>", is_number ? " class=\"num\"" : "", escaped(text));
}

std::string source_text(const Place& from) {
  return from.file.empty() ? "" : fmt::format("{}:{}", from.file, from.line);
}

std::string left_out_table(const MadeZone& made) {
  if (made.stored.map.outliers().empty()) return "<p>No probe was left out.</p>\n";
  std::string out =
      "<div class=\"scroll\"><table class=\"grid\"><tr><th>probe</th><th>read at</th>"
      "<th class=\"num\">place mm</th><th class=\"num\">height mm</th>"
      "<th class=\"num\">deviation mm</th><th class=\"num\">sigmas</th>"
      "<th class=\"num\">chance</th></tr>\n";
  for (const SurfaceOutlier& outlier : made.stored.map.outliers()) {
    const ProbePoint& probe = made.stored.points[outlier.i_point];
    out += "<tr>" + zone_cell(outlier.name, false) + zone_cell(source_text(probe.from), false) +
           zone_cell(place_text(probe.place)) +
           zone_cell(report::fixed(probe.measured.height.in_mm(), 4)) +
           zone_cell(report::fixed_signed(outlier.deviation.in_mm(), 4)) +
           zone_cell(report::fixed(std::abs(outlier.deviation / outlier.sigma), 1)) +
           zone_cell(outlier.chance < 1e-9 ? "below 1e-9" : fmt::format("{:.2g}", outlier.chance)) +
           "</tr>\n";
  }
  return out + "</table></div>\n";
}

std::string missing_table(const MadeMap& made) {
  if (made.missing.empty()) return {};
  std::string out =
      "<h2>Not probed</h2>\n<section>\n<div class=\"scroll\"><table class=\"grid\"><tr>"
      "<th>probe</th><th>read at</th><th class=\"num\">place mm</th><th>why</th></tr>\n";
  for (const MissingProbe& missing : made.missing) {
    out += "<tr>" + zone_cell(missing.name, false) + zone_cell(source_text(missing.from), false) +
           zone_cell(place_text(missing.place)) + zone_cell(missing.reason, false) + "</tr>\n";
  }
  return out + "</table></div>\n</section>\n";
}

/// Table of the others' predictions of each probe that makes the surface.
std::string probes_table(const MadeZone& made) {
  std::string out =
      "<details><summary>All probes that make the surface</summary><div class=\"scroll\">"
      "<table class=\"grid\"><tr><th>probe</th><th>read at</th><th class=\"num\">place mm</th>"
      "<th class=\"num\">height mm</th><th class=\"num\">off the surface &#181;m</th>"
      "<th class=\"num\">off the others' prediction &#181;m</th><th class=\"num\">chance</th>"
      "</tr>\n";
  const HeightMap& map = made.stored.map;
  for (std::size_t k = 0; k < map.kept().size(); ++k) {
    const ProbePoint& probe = made.stored.points[map.kept()[k]];
    const LeftOutProbe& left_out = map.surface().left_out()[k];
    const Length residual = probe.measured.height - map.surface().at(probe.place).height;
    out +=
        "<tr>" + zone_cell(name_of(probe), false) + zone_cell(source_text(probe.from), false) +
        zone_cell(place_text(probe.place)) +
        zone_cell(report::fixed(probe.measured.height.in_mm(), 4)) +
        zone_cell(report::fixed_signed(residual.in_um(), 2)) +
        zone_cell(left_out.deviation ? report::fixed_signed(left_out.deviation->in_um(), 2) : "-") +
        zone_cell(left_out.deviation ? fmt::format("{:.2f}", left_out.chance) : "-") + "</tr>\n";
  }
  return out + "</table></div></details>\n";
}

std::string unused_table(const MadeMap& made) {
  const auto unused = made.stored.map.unused();
  if (unused.empty()) return {};
  std::string out =
      "<h2>Probes not used</h2>\n<section>\n<div class=\"scroll\"><table class=\"grid\"><tr>"
      "<th>probe</th><th>read at</th><th class=\"num\">place mm</th>"
      "<th class=\"num\">height mm</th><th>why</th></tr>\n";
  for (const UnusedProbe& one : unused) {
    const ProbePoint& probe = made.stored.points[one.i_point];
    out += "<tr>" + zone_cell(probe.name, false) + zone_cell(source_text(probe.from), false) +
           zone_cell(place_text(probe.place)) +
           zone_cell(report::fixed(probe.measured.height.in_mm(), 4)) +
           zone_cell(one.reason, false) + "</tr>\n";
  }
  return out + "</table></div>\n</section>\n";
}

/// Figures, pictures and probes of one zone, or of the map without zones.
std::string zone_sections(const MadeMap& made, std::size_t i_zone) {
  const MadeZone& zone = made.zones[i_zone];
  const HeightMap& map = zone.stored.map;
  const std::string of_zone = made.has_zones() ? " of zone " + escaped(zone.name) : "";
  std::string out;
  if (made.has_zones()) out += fmt::format("<h2>Zone {}</h2>\n", escaped(zone.name));
  out += fmt::format(
      "<section>\n<p><b>{}</b></p>\n<p class=\"quiet\">{}.</p>\n{}</section>\n"
      "<h2>Pictures{}</h2>\n<section>\n<div class=\"maps\">\n",
      escaped(map.surface().summary()),
      escaped(map.reason()),
      zone_tiles(zone),
      of_zone);
  for (const report::Drawing& drawing : zone_drawings(made, i_zone)) {
    out += contours::inline_svg(drawing, "Contours over the panel");
  }
  const bool has_blanks = made.has_zones() || !made.stored.map.voids().all().empty();
  out += fmt::format(
      "</div>\n<p class=\"quiet\">Dots: probes; red crosses: probes left out, with how far they "
      "are off in mm; dashes: the probes' hull. Thin grey hatching: extrapolated, up to {:g} mm "
      "outside; no heights beyond. Dense violet hatching: filled between probes, where none "
      "vouches "
      "for the height. {}{}.</p>\n</section>\n",
      map.options().max_extrapolation.in_mm(),
      has_blanks ? "White: voids, and what belongs to another zone or none; blue: borders of "
                   "zones; violet crosses: probes not used. "
                 : "",
      escaped("Coverage: " + coverage_text(zone.facts)));
  out += fmt::format(
      "<h2>Probes left out{}</h2>\n<section>\n{}</section>\n", of_zone, left_out_table(zone));
  out += fmt::format("<h2>Probes{}</h2>\n<section>\n{}</section>\n", of_zone, probes_table(zone));
  return out;
}

}  // namespace

std::string map_html(const MadeMap& made, const Provenance& provenance) {
  std::string out = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head>\n"
      "<meta charset=\"utf-8\"/>\n<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\"/>\n<title>Surface map {0} - panelcal</title>\n"
      "<style>{1}{2}{3}</style>\n</head>\n<body>\n<main>\n<h1>Surface map <b>{0}</b></h1>\n",
      escaped(made.file),
      report::kStyle,
      contours::kContourStyle,
      kSurfacePageStyle);
  for (std::size_t i = 0; i < made.zones.size(); ++i) out += zone_sections(made, i);
  const Voids& voids = made.stored.map.voids();
  if (!voids.all().empty()) {
    out += fmt::format("<h2>Voids</h2>\n<section>\n<p>{}.</p>\n</section>\n",
                       escaped(voids_text(voids)));
  }
  out += unused_table(made) + missing_table(made);
  out += "<footer>\n<dl>\n";
  for (const auto& [key, value] : provenance) {
    out += fmt::format("<dt>{}</dt><dd class=\"mono\">{}</dd>\n", escaped(key), escaped(value));
  }
  return out + "</dl>\n</footer>\n</main>\n</body>\n</html>\n";
}

}  // namespace panelcal::surface
