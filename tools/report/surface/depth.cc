// SPDX-License-Identifier: Apache-2.0
#include "tools/report/surface/depth.h"

#include <string_view>

#include "machine/job/summary/depth_summary.h"
#include "tools/figures/text.h"
#include "tools/report/surface/depth_map.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

std::string depth_risk_chip(const Tolerances& tolerances, double risk) {
  const std::string_view chip = risk > tolerances.hold_above   ? "chip refused"
                                : risk > tolerances.warn_above ? "chip suspect"
                                                               : "chip";
  return fmt::format("<span class=\"{}\">{}</span>", chip, risk_html(risk));
}

std::string worst_depth_place(const DepthVerdict::WorstPlace& worst) {
  const std::string axis =
      worst.error.axis ? fmt::format(" on Z axis {}", *worst.error.axis) : std::string();
  return fmt::format("{}: {} &#177; {} &#181;m{}",
                     place_html(worst.line, worst.file, worst.path, worst.nominal.in_mm()),
                     fixed_signed(worst.error.mean.in_um(), 1),
                     fixed(worst.error.sigma.in_um(), 1),
                     axis);
}

std::string depth_row_html(const Tolerances& tolerances,
                           int number,
                           const DepthVerdict::ToolFigures& tool) {
  std::string out = fmt::format("<tr><td>T{}</td>", number) +
                    number_cell(grouped(tool.places.n_judged + tool.places.n_unjudged)) +
                    number_cell(depth_tolerance_text(tool.tolerance));
  if (tool.places.n_judged == 0) {
    return out + "<td colspan=\"7\" class=\"quiet\">not judged</td></tr>\n";
  }
  out += number_cell(fixed_signed(tool.largest_mean.in_um(), 2)) +
         number_cell(fixed(tool.largest_sigma.in_um(), 2)) +
         number_cell(risk_text(tool.expected_too_shallow) + " / " +
                     risk_text(tool.expected_too_deep)) +
         number_cell(grouped(tool.places.n_warned) + " / " + grouped(tool.places.n_held));
  return out + fmt::format("<td>{}</td><td>{}</td><td class=\"quiet\">{}</td></tr>\n",
                           depth_risk_chip(tolerances, tool.worst.risk.too_shallow),
                           depth_risk_chip(tolerances, tool.worst.risk.too_deep),
                           worst_depth_place(tool.worst));
}

}  // namespace

std::string depth_tile(const DepthVerdict* verdict) {
  if (verdict == nullptr || verdict->places().n_judged == 0) return {};
  const JudgedPlaces places = verdict->places();
  return fmt::format(
      "<div><dt>depths expected to break their tolerance</dt><dd>{}<small>of {}; "
      "<a href=\"#depth\">worst risk</a> {}</small></dd></div>\n",
      risk_html(places.expected_broken),
      grouped(places.n_judged),
      risk_html(verdict->worst_tool()->worst.risk.either()));
}

std::string depth_section(const DepthVerdict* verdict) {
  if (verdict == nullptr) return {};
  std::string sentence = escaped(verdict->sentence());
  sentence[0] = static_cast<char>(sentence[0] - 'a' + 'A');
  std::string out = "<h2 id=\"depth\">Depth</h2>\n<section>\n<p><b>" + sentence + ".</b></p>\n";
  if (!verdict->by_tool().empty()) {
    out +=
        "<div class=\"scroll\"><table class=\"grid\"><tr><th>tool</th><th class=\"num\">depths</th>"
        "<th class=\"num\">shallow / deep &#181;m</th><th class=\"num\">farthest off</th>"
        "<th class=\"num\">largest sigma</th><th class=\"num\">expected shallow / deep</th>"
        "<th class=\"num\">warn / hold</th><th>too shallow</th><th>too deep</th>"
        "<th>worst place</th></tr>\n";
    for (const auto& [number, tool] : verdict->by_tool()) {
      out += depth_row_html(verdict->tolerances(), number, tool);
    }
    out += "</table></div>\n";
  }
  out += depth_map_figures(*verdict);
  out += "<ul>\n";
  for (const std::string& line : surface_lines(*verdict)) {
    out += "<li>" + escaped(line) + "</li>\n";
  }
  return out +
         fmt::format(
             "</ul>\n<p class=\"quiet\">Lengths in &#181;m; deeper than wanted is positive. "
             "The map of all probes gives the height of the board at each place, and how sure "
             "that is; what the machine is told counts on a probe, a grid or a map made "
             "before. To the map's "
             "sigma comes that of the machine's depth, {} &#181;m.</p>\n</section>\n",
             shortest(verdict->errors().depth_sigma().in_um()));
}

}  // namespace panelcal::report
