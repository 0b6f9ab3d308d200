// SPDX-License-Identifier: Apache-2.0
#include "tools/report/input/budget.h"

#include <algorithm>
#include <cmath>

#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal {

namespace report {
namespace {

std::string why_shown(const HoleBudget& hole) {
  if (!hole.is_likeliest_to_break) return "The least certain hole";
  if (!hole.risk) return "The place likeliest to break its tolerance";
  return fmt::format("The place likeliest to break its tolerance, with a risk of {}",
                     escaped(risk_text(*hole.risk)));
}

double sigma_um(double variance_mm2) {
  return std::sqrt(std::max(0.0, variance_mm2)) * 1e3;
}

std::string budget_row(std::string_view source,
                       const Eigen::Matrix2d& cov_mm2,
                       double whole_mm2,
                       std::string_view shared) {
  const double percent = whole_mm2 > 0 ? 100 * cov_mm2.trace() / whole_mm2 : 0;
  return fmt::format(
      "<tr><td>{}</td><td class=\"num\">{}</td><td class=\"num\">{}</td>"
      "<td class=\"num\">{} %</td><td><span class=\"meter good\"><span style=\"width:{:.0f}%\">"
      "</span></span></td><td>{}</td></tr>\n",
      escaped(source),
      fixed(sigma_um(cov_mm2(0, 0)), 2),
      fixed(sigma_um(cov_mm2(1, 1)), 2),
      fixed(percent, 1),
      std::clamp(percent, 0.0, 100.0),
      shared);
}

/// Paragraph on errors that holes have in common: they cannot be seen by comparing them with each
/// other.
std::string common_paragraph(const ErrorBudget& budget) {
  Eigen::Matrix2d common_mm2 = Eigen::Matrix2d::Zero();
  for (const BudgetTerm& term : budget) {
    if (term.shared == SharedBy::AllHoles) common_mm2 += term.cov_mm2;
  }
  const std::string size =
      common_mm2.trace() > 0
          ? fmt::format("here {} &#181;m in x and {} &#181;m in y, one standard deviation",
                        fixed(sigma_um(common_mm2(0, 0)), 2),
                        fixed(sigma_um(common_mm2(1, 1)), 2))
          : "which the machine's file does not state";
  return fmt::format(
      "<p>The spindle-camera offset and its drift move <b>all holes of the job alike</b>: {}. No "
      "further target makes that smaller, only a new calibration of the offset. Errors of targets "
      "are common to the holes of one fit, those of a camera's calibration to all holes whose "
      "targets "
      "it saw.</p>\n",
      size);
}

}  // namespace

std::string budget_section(const std::optional<HoleBudget>& hole) {
  if (!hole || hole->budget.empty()) return {};
  const Eigen::Matrix2d total = total_mm2(hole->budget);
  std::string unknown;
  std::string rows;
  for (const BudgetTerm& term : hole->budget) {
    if (term.counts()) {
      rows += budget_row(term.source, term.cov_mm2, total.trace(), name(term.shared));
    } else {
      unknown += fmt::format("{}{}", unknown.empty() ? "" : ", ", escaped(term.source));
    }
  }
  const std::string where =
      fmt::format("line {}{}{}",
                  hole->line,
                  hole->file.empty() ? "" : " of " + escaped(hole->file),
                  hole->path.empty() ? "" : ", board " + path_text(hole->path));
  std::string out = fmt::format(
      "<h2 id=\"budget\">Where the uncertainty comes from</h2>\n<section>\n"
      "<p>{}: {}, T{}, nominal {} mm.</p>\n"
      "<div class=\"scroll\"><table class=\"grid\"><tr><th>source</th><th class=\"num\">sigma x, "
      "&#181;m</th><th class=\"num\">sigma y, &#181;m</th><th class=\"num\">share</th><th></th>"
      "<th>common to</th></tr>\n{}{}</table></div>\n",
      why_shown(*hole),
      where,
      hole->tool,
      point_text(hole->nominal.in_mm()),
      rows,
      budget_row("total", total, total.trace(), ""));
  if (!unknown.empty()) {
    out += fmt::format(
        "<p class=\"quiet\">Not stated in the machine's file, and so not counted: {}.</p>\n",
        unknown);
  }
  return out + common_paragraph(hole->budget) + "</section>\n";
}

}  // namespace report
}  // namespace panelcal
