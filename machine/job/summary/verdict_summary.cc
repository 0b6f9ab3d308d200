// SPDX-License-Identifier: Apache-2.0
#include "machine/job/summary/verdict_summary.h"

#include "calib/base/append_format.h"
#include <fmt/format.h>

namespace panelcal {

std::vector<ToolRow> tool_rows(const JobVerdict& verdict, const TruthComparison* truth) {
  std::vector<ToolRow> rows;
  for (const auto& [number, figures] : verdict.by_tool()) {
    ToolRow row{.tool = number, .predicted = &figures, .actual = nullptr};
    if (truth != nullptr) {
      const auto found = truth->by_tool().find(number);
      if (found != truth->by_tool().end()) row.actual = &found->second.corrected;
    }
    rows.push_back(row);
  }
  return rows;
}

std::string cpk_text(const JobVerdict::ToolFigures& tool, const RiskBasis& basis) {
  return basis.tells_risk() ? cpk_text(tool.predicted, tool.tolerance) : "none";
}

std::string cpk_text(const RadialFigures& figures, std::optional<Length> tolerance) {
  const std::optional<double> cpk = tolerance ? figures.cpk(*tolerance) : std::nullopt;
  return cpk ? fmt::format("{:.2f}", *cpk) : "-";
}

namespace {

std::string risk_text(const JobVerdict::ToolFigures& tool, const RiskBasis& basis) {
  if (tool.n_judged == 0) return "-";
  if (!basis.tells_risk()) return "no figure";
  return tool.stated_risk < 1e-12 ? "<1e-12" : fmt::format("{:.1e}", tool.stated_risk);
}

}  // namespace

std::string verdict_summary(const JobVerdict& verdict, const TruthComparison* truth) {
  std::string out = "tolerance, predicted";
  if (truth != nullptr) out += " and against truth";
  out += verdict.basis().is_of_fit_only ? " (lengths in um, sigma of the fit only)\n"
                                        : " (lengths in um)\n";
  internal::append_format(out,
                          "{:>6} {:>8} {:>9} {:>8} {:>8} {:>9} {:>6} {:>6} {:>6} {:>9}",
                          "tool",
                          "places",
                          "tolerance",
                          "sigma",
                          "95 %",
                          "mean+3s",
                          "Cpk",
                          "warn",
                          "hold",
                          "risk");
  if (truth != nullptr)
    internal::append_format(out, " |{:>8} {:>8} {:>6}", "max", "mean+3s", "Cpk");
  out += '\n';
  for (const ToolRow& row : tool_rows(verdict, truth)) {
    const JobVerdict::ToolFigures& tool = *row.predicted;
    internal::append_format(out,
                            "{:>6} {:>8} {:>9} {:>8.2f} {:>8.2f} {:>9.2f} {:>6} {:>6} {:>6} {:>9}",
                            fmt::format("T{}", row.tool),
                            tool.predicted.n + tool.n_uncorrected,
                            tool.tolerance ? fmt::format("{:.1f}", tool.tolerance->in_um()) : "-",
                            tool.largest_sigma.in_um(),
                            tool.largest_radius_95.in_um(),
                            tool.predicted.mean_plus_3_sigma().in_um(),
                            cpk_text(tool, verdict.basis()),
                            tool.n_warned,
                            tool.n_held,
                            risk_text(tool, verdict.basis()));
    if (row.actual != nullptr) {
      internal::append_format(out,
                              " |{:>8.2f} {:>8.2f} {:>6}",
                              row.actual->max().in_um(),
                              row.actual->radial().mean_plus_3_sigma().in_um(),
                              cpk_text(row.actual->radial(), tool.tolerance));
    }
    out += '\n';
  }
  return out + "verdict: " + verdict.sentence();
}

}  // namespace panelcal
