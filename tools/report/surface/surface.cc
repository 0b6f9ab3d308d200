// SPDX-License-Identifier: Apache-2.0
#include "tools/report/surface/surface.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

/// More rows do not help; the saved readings have them all.
constexpr std::size_t kMaxSurfaceRows = 500;

std::string row_of(const ProbeReading& reading, std::size_t n_axes) {
  const ProbeRequest& request = reading.request;
  const std::string path = path_text(request.path);
  std::string out =
      fmt::format("<tr><td>#{}</td><td>{} in line {}{}</td><td>{}</td><td class=\"num\">{}</td>",
                  request.seq,
                  escaped(request.command),
                  request.line,
                  path.empty() ? "" : ", board " + path,
                  request.memory ? fmt::format("L{}", *request.memory) : "",
                  point_text(request.nominal.in_mm()));
  if (reading.status != ProbeStatus::Found || reading.heights.empty()) {
    return out + fmt::format("<td colspan=\"{}\"><b>not found</b> {}</td></tr>\n",
                             n_axes + 1,
                             escaped(reading.reason));
  }
  for (std::size_t axis = 0; axis < n_axes; ++axis) {
    const bool has_axis = axis < reading.heights.size();
    out += fmt::format("<td class=\"num\">{}</td>",
                       has_axis ? fixed(reading.heights[axis].height.in_mm(), 4) : "");
  }
  const Length deviation = reading.heights.front().height - request.reference;
  return out + fmt::format("<td class=\"num\">{}</td></tr>\n", fixed_signed(deviation.in_um(), 1));
}

std::string row_of(const FilledNode& node) {
  std::string out = fmt::format(
      "<tr><td></td><td><b>not probed</b>, {}: sigma {} &#181;m</td><td></td><td "
      "class=\"num\">{}</td>",
      name(node.source),
      fixed(node.heights.front().sigma.in_um(), 1),
      point_text(node.place.in_mm()));
  for (const HeightEstimate& height : node.heights) {
    out += fmt::format("<td class=\"num\">{}</td>", fixed(height.height.in_mm(), 4));
  }
  return out + "<td></td></tr>\n";
}

}  // namespace

std::string surface_section(const Survey& survey, const std::string& use) {
  if (survey.probes.empty() && use.empty()) return {};
  const std::string head = "<h2 id=\"surface\">Surface</h2>\n<section>" +
                           (use.empty() ? "" : "<p>" + escaped(use) + ".</p>\n");
  if (survey.probes.empty()) return head + "</section>\n";
  std::size_t n_axes = 1;
  for (const ProbeReading& reading : survey.probes) {
    n_axes = std::max(n_axes, reading.heights.size());
  }
  std::string out = head +
                    "<div class=\"scroll\"><table class=\"grid\">"
                    "<tr><th>probe</th><th>asked by</th><th></th><th class=\"num\">nominal mm</th>";
  for (std::size_t axis = 0; axis < n_axes; ++axis) {
    out += fmt::format("<th class=\"num\">height{} mm</th>",
                       n_axes == 1 ? "" : fmt::format(", Z axis {},", axis));
  }
  out += "<th class=\"num\">from expected &#181;m</th></tr>\n";
  const std::size_t n_rows = std::min(survey.probes.size(), kMaxSurfaceRows);
  for (std::size_t i = 0; i < n_rows; ++i) out += row_of(survey.probes[i], n_axes);
  for (const FilledNode& node : survey.filled_nodes) out += row_of(node);
  out += "</table></div>\n";
  if (n_rows < survey.probes.size()) {
    const auto n_more = static_cast<std::int64_t>(survey.probes.size() - n_rows);
    out += fmt::format("<p class=\"quiet\">{} more in what --save-probes writes.</p>\n",
                       counted(n_more, "place"));
  }
  return out + "</section>\n";
}

}  // namespace panelcal::report
