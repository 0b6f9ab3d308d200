// SPDX-License-Identifier: Apache-2.0
#include "tools/report/verdict.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "machine/job/summary/verdict_summary.h"
#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

std::string um_2(Length length) {
  return fixed(length.in_um(), 2);
}

std::string worst_position_place(const JobVerdict::ToolFigures& tool) {
  if (tool.n_judged == 0) return {};
  const JobVerdict::WorstPlace& worst = tool.worst;
  return place_html(worst.line, worst.file, worst.path, worst.nominal.in_mm());
}

std::string_view chip_class(const JobVerdict::ToolFigures& tool) {
  if (tool.n_held > 0) return "chip refused";
  return tool.n_warned > 0 ? "chip suspect" : "chip";
}

std::string position_risk_chip(const JobVerdict::ToolFigures& tool, const RiskBasis& basis) {
  if (tool.n_judged == 0) return "<span class=\"quiet\">not judged</span>";
  return fmt::format("<span class=\"{}\">{}</span>",
                     chip_class(tool),
                     basis.tells_risk() ? risk_html(tool.stated_risk) : "no figure");
}

std::string tool_row_html(const ToolRow& row, const RiskBasis& basis, bool has_truth) {
  const JobVerdict::ToolFigures& tool = *row.predicted;
  std::string out = fmt::format("<tr><td>T{}</td>", row.tool);
  out += number_cell(grouped(tool.predicted.n + tool.n_uncorrected));
  out += number_cell(tool.tolerance ? fixed(tool.tolerance->in_um(), 1) : "-");
  out += number_cell(um_2(tool.largest_sigma)) + number_cell(um_2(tool.largest_radius_95));
  out += number_cell(um_2(tool.predicted.mean())) +
         number_cell(um_2(tool.predicted.mean_plus_3_sigma()));
  out += number_cell(cpk_text(tool, basis));
  if (has_truth && row.actual != nullptr) {
    const RadialFigures actual = row.actual->radial();
    out += number_cell("<b>" + um_2(row.actual->max()) + "</b>") +
           number_cell("<b>" + um_2(actual.mean_plus_3_sigma()) + "</b>") +
           number_cell("<b>" + cpk_text(actual, tool.tolerance) + "</b>");
  } else if (has_truth) {
    out += number_cell("") + number_cell("") + number_cell("");
  }
  out +=
      number_cell(tool.n_judged == 0 ? "" : grouped(tool.n_warned) + " / " + grouped(tool.n_held));
  return out + fmt::format("<td>{}</td><td class=\"quiet\">{}</td></tr>\n",
                           position_risk_chip(tool, basis),
                           worst_position_place(tool));
}

std::string verdict_table(const ReportInput& input) {
  const bool has_truth = input.truth != nullptr;
  std::string out =
      "<div class=\"scroll\"><table class=\"grid\"><tr><th>tool</th><th class=\"num\">places</th>"
      "<th class=\"num\">tolerance &#181;m</th><th class=\"num\">largest sigma";
  if (input.verdict->basis().is_of_fit_only) out += ", of the fit only";
  out +=
      "</th>"
      "<th class=\"num\">95 % radius</th><th class=\"num\">mean</th>"
      "<th class=\"num\">mean + 3 sigma</th><th class=\"num\">Cpk</th>";
  if (has_truth) {
    out +=
        "<th class=\"num\">true: max</th><th class=\"num\">mean + 3 sigma</th>"
        "<th class=\"num\">Cpk</th>";
  }
  out += "<th class=\"num\">warn / hold</th><th>risk</th><th>worst place</th></tr>\n";
  for (const ToolRow& row : tool_rows(*input.verdict, input.truth)) {
    out += tool_row_html(row, input.verdict->basis(), has_truth);
  }
  return out + "</table></div>\n";
}

// --- picture of the risks ----------------------------------------------------------------------

constexpr double kBar_px = 46;
constexpr double kPlot_px = 120;  ///< height
constexpr double kVerdictTop_px = 18;
constexpr double kVerdictLeft_px = 8;

/// Heights are logarithms: one hole beside a million has to be seen.
double height_px(std::int64_t n, std::int64_t most) {
  const auto logarithm = [](std::int64_t count) {
    return std::log10(1.0 + static_cast<double>(count));
  };
  return n == 0 ? 0 : std::max(4.0, kPlot_px * logarithm(n) / logarithm(most));
}

std::string bar(std::size_t i, const JobVerdict::Decade& decade, std::int64_t most) {
  const double x = kVerdictLeft_px + kBar_px * static_cast<double>(i);
  const double height = height_px(decade.n(), most);
  double y = kVerdictTop_px + kPlot_px - height;
  std::string out = fmt::format("<text class=\"mid\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>",
                                x + kBar_px / 2,
                                y - 4,
                                grouped(decade.n()));
  const std::array<std::pair<std::int64_t, std::string_view>, 3> parts = {
      {{decade.n_held, "bad"}, {decade.n_warned, "warn"}, {decade.n_good, "good"}}};
  for (const auto& [n, color] : parts) {
    if (n == 0) continue;
    const double part = height * static_cast<double>(n) / static_cast<double>(decade.n());
    out += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{:.1f}\" "
        "style=\"fill:var(--{})\"/>",
        x + 3,
        y,
        kBar_px - 6,
        part,
        color);
    y += part;
  }
  return out;
}

std::string limit_line(double probability, std::string_view name) {
  const double at = std::log10(std::max(probability, 1e-13)) - JobVerdict::kLowestDecade;
  const double x = kVerdictLeft_px + kBar_px * std::clamp(1 + at, 0.0, 13.0);
  return fmt::format(
      "<path class=\"before\" d=\"M{0:.1f} {1}V{2}\"/><text class=\"mid\" x=\"{0:.1f}\" "
      "y=\"{3}\">{4}</text>",
      x,
      kVerdictTop_px - 4,
      kVerdictTop_px + kPlot_px,
      kVerdictTop_px + kPlot_px + 32,
      name);
}

std::string decades_picture(const JobVerdict& verdict) {
  std::int64_t most = 1;
  for (const JobVerdict::Decade& decade : verdict.decades()) most = std::max(most, decade.n());
  const double width = 2 * kVerdictLeft_px + kBar_px * JobVerdict::kDecades;
  std::string out = fmt::format(
      "<figure><svg class=\"panel\" role=\"img\" aria-label=\"How many places have which risk\" "
      "viewBox=\"0 0 {0} {1}\" style=\"max-width:{0}px\">",
      width,
      kVerdictTop_px + kPlot_px + 38);
  for (std::size_t i = 0; i < JobVerdict::kDecades; ++i) {
    if (verdict.decades()[i].n() > 0) out += bar(i, verdict.decades()[i], most);
    if (i == 0) continue;
    const int exponent = JobVerdict::kLowestDecade + static_cast<int>(i) - 1;
    out += fmt::format("<text class=\"mid\" x=\"{:.1f}\" y=\"{}\">1e{}</text>",
                       kVerdictLeft_px + kBar_px * static_cast<double>(i),
                       kVerdictTop_px + kPlot_px + 15,
                       exponent);
  }
  out += fmt::format("<path class=\"frame\" d=\"M{} {}H{}\"/>",
                     kVerdictLeft_px,
                     kVerdictTop_px + kPlot_px,
                     width - kVerdictLeft_px);
  out += limit_line(verdict.tolerances().warn_above, "warn");
  out += limit_line(verdict.tolerances().hold_above, "hold");
  return out +
         "</svg>\n<figcaption>How many places have which probability of breaking their tolerance; "
         "the left bar is everything below 1e-12. Heights are logarithms of the "
         "counts.</figcaption></figure>\n";
}

}  // namespace

std::string verdict_section(const ReportInput& input) {
  if (input.verdict == nullptr) return {};
  const JobVerdict& verdict = *input.verdict;
  std::string sentence = escaped(verdict.sentence());
  sentence[0] = static_cast<char>(sentence[0] - 'a' + 'A');
  std::string out = "<h2 id=\"tolerance\">Tolerance</h2>\n<section>\n<p><b>" + sentence +
                    ".</b></p>\n" + verdict_table(input);
  const bool tells_all = verdict.basis().kind == RiskBasis::Kind::Stated;
  if (verdict.n_judged() > 0 && tells_all) out += decades_picture(verdict);
  out +=
      "<p class=\"quiet\">Lengths in &#181;m. Places are holes, ends of slots, and corners and "
      "starts of routs. Predicted: what the machine's and the measurements' stated errors make of "
      "the distance from the right place.";
  if (verdict.basis().tells_risk()) {
    out += " Cpk is (tolerance - mean) / (3 sigma) of that distance.";
  }
  if (tells_all) {
    out +=
        " The expected number of broken places is right although all places share the fit's error; "
        "that error breaks many of them at once or none.";
  }
  if (input.truth != nullptr) {
    out +=
        " True: holes as commanded against the simulated panel, without what the stage and the "
        "drill add.";
  }
  return out + "</p>\n</section>\n";
}

}  // namespace panelcal::report
