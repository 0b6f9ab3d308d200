// SPDX-License-Identifier: Apache-2.0
#include "tools/report/fits/fits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "tools/figures/text.h"
#include "tools/report/fits/causes.h"
#include "tools/report/fits/fit_numbers.h"
#include "tools/report/fits/models.h"
#include "tools/report/input/facts.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::report {
namespace {

/// More accepted board fits than this are folded into one line.
constexpr std::size_t kMaxLooseFits = 12;

std::string gate_row(const GateVerdict& gate) {
  const double ratio = gate_ratio(gate);
  const std::string target =
      gate.i_target ? fmt::format(" of target {}", *gate.i_target + 1) : std::string();
  return fmt::format(
      "<tr><td>{}{}</td><td class=\"num\">{}</td><td class=\"num\">{}</td>"
      "<td><span class=\"meter {}\"><span style=\"width:{:.0f}%\"></span></span></td>"
      "<td><span class=\"chip {}\">{}</span></td></tr>\n",
      escaped(gate.gate),
      target,
      gate_value(gate),
      gate_limit(gate),
      gate.accepted ? "good" : "refused",
      std::min(100.0, 100 * ratio),
      gate.accepted ? "good" : "refused",
      gate.accepted ? "pass" : "fail");
}

std::string gates_table(const SeriesResult& series) {
  const std::string limits =
      fmt::format("<p class=\"quiet\">Gates: {}.</p>\n", escaped(gates_text(series.limits)));
  if (series.gates.empty()) return limits;
  std::string out =
      "<div class=\"scroll\"><table class=\"grid\"><tr><th>gate</th><th class=\"num\">value</th>"
      "<th class=\"num\">limit</th><th></th><th></th></tr>\n";
  for (const GateVerdict& gate : series.gates) out += gate_row(gate);
  return out + "</table></div>\n" + limits;
}

std::string fit_paragraph(const SeriesResult& series, const FitNumbers& n) {
  const std::string layers =
      series.layer_spread ? fmt::format(" The layers of a target are at most {} &#181;m apart.",
                                        fixed(series.layer_spread->in_um(), 2))
                          : "";
  const double ratio = series.misfit_ratio();
  const std::string misfit =
      ratio == 1 ? ""
                 : fmt::format(" The sigma of this fit has grown {} times by it.", fixed(ratio, 1));
  return fmt::format(
      "<p>{} from {}, model \"{}\". Chi square {} with {} of freedom: {}.{} "
      "Centre of the targets {} mm.{}</p>\n",
      series.level == CorrectionLevel::Base ? "Base fit" : "Nested fit",
      counted(static_cast<std::int64_t>(series.points.size()), "target"),
      model_text(series),
      fixed(n.chi_square, 2),
      n.degrees_of_freedom == 1 ? "1 degree" : fmt::format("{} degrees", n.degrees_of_freedom),
      chi_square_meaning(n.chi_square, n.degrees_of_freedom),
      misfit,
      point_text(n.centroid_mm),
      layers);
}

/// Of a series whose pictures had several candidates: what decided, or why nothing did.
std::string assignment_paragraph(const SeriesResult& series) {
  if (!series.assignment) return {};
  const SeriesAssignment& assignment = *series.assignment;
  return fmt::format("<p><b>{}</b> Candidates that count, target by target: {}. {}.</p>\n",
                     assignment.is_certain() ? "Chosen jointly." : "Held: not separable.",
                     fmt::join(assignment.n_candidates, ", "),
                     escaped(assignment.text()));
}

std::string unfitted(const ReportInput& input, const SeriesResult& series) {
  std::string lost;
  for (const std::size_t i : series.measurements) {
    const auto& measurements = survey_of(input).measurements;
    if (i >= measurements.size() || measurements[i].status == MeasurementStatus::Found) continue;
    lost += fmt::format("{}<a href=\"#target-{}\">#{}</a>",
                        lost.empty() ? "" : ", ",
                        measurements[i].request.seq,
                        measurements[i].request.seq);
  }
  return lost.empty() ? "No fit: its targets do not determine one, see the messages"
                      : "No fit: target " + lost + " is missing";
}

std::string series_block(const ReportInput& input, const SeriesResult& series, bool is_open) {
  const std::optional<FitNumbers> numbers = fit_numbers(series);
  const std::string words =
      numbers ? fit_sentence(*numbers, series.level) : unfitted(input, series);
  std::string out = fmt::format(
      "<details class=\"fit\"{}><summary><span class=\"chip {}\">{}</span> <b>{}</b> "
      "<span class=\"words\">{}.</span></summary>\n",
      is_open || !series.is_accepted() ? " open=\"open\"" : "",
      series.is_accepted() ? "good" : "refused",
      series.is_accepted() ? "pass" : "fail",
      series_name(series),
      words);
  if (numbers) out += fit_paragraph(series, *numbers) + gates_table(series);
  out += assignment_paragraph(series) + models_block(series);
  out += causes_block(survey_of(input), series);
  return out + "</details>\n";
}

struct ResidualRange {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  std::string text(int n_decimals) const {
    return fixed_signed(low, n_decimals) + " to " + fixed_signed(high, n_decimals);
  }
};

/// Fits of many boards, as ranges.
std::string ranges_of(const std::vector<const SeriesResult*>& boards) {
  ResidualRange shift_x, shift_y, rotation;
  for (const SeriesResult* board : boards) {
    const std::optional<FitNumbers> n = fit_numbers(*board);
    if (!n) continue;
    shift_x.add(n->shift_x_mm.value * 1e3);
    shift_y.add(n->shift_y_mm.value * 1e3);
    if (n->model != PanelModel::Offset) rotation.add(n->rotation_rad.value * 1e3);
  }
  std::string out = fmt::format(
      "shifted by {} &#181;m in x and {} &#181;m in y", shift_x.text(1), shift_y.text(1));
  if (std::isfinite(rotation.low)) out += fmt::format(", rotated by {} mrad", rotation.text(3));
  return out;
}

/// Paragraph on the frame of nested fits, once.
std::string frame_paragraph(const Survey& survey) {
  const bool has_nested = std::ranges::any_of(survey.series, [](const SeriesResult& series) {
    return series.level == CorrectionLevel::Nested && series.base_series.has_value();
  });
  return has_nested ? "<p>Board fits are on top of their panel's fit.</p>\n" : "";
}

std::string pooled_paragraph(const Survey& survey) {
  const PooledChiSquare pooled = pooled_chi_square(survey);
  if (pooled.degrees_of_freedom == 0 || survey.series.size() < 2) return {};
  return fmt::format("<p>All fits together: chi square {} with {} of freedom, {}.</p>\n",
                     fixed(pooled.chi_square, 2),
                     pooled.degrees_of_freedom == 1
                         ? "1 degree"
                         : fmt::format("{} degrees", pooled.degrees_of_freedom),
                     chi_square_meaning(pooled.chi_square, pooled.degrees_of_freedom));
}

}  // namespace

std::string fits_section(const ReportInput& input) {
  const Survey& survey = survey_of(input);
  if (survey.series.empty()) return "<p class=\"quiet\">Nothing was fitted.</p>\n";
  std::string refused;
  std::string panel;
  std::string boards;
  std::vector<const SeriesResult*> accepted_boards;
  for (const SeriesResult& series : survey.series) {
    if (!series.is_accepted()) {
      refused += series_block(input, series, true);
    } else if (series.level == CorrectionLevel::Base) {
      panel += series_block(input, series, survey.series.size() <= kMaxLooseFits);
    } else {
      boards += series_block(input, series, false);
      accepted_boards.push_back(&series);
    }
  }
  if (accepted_boards.size() > kMaxLooseFits) {
    boards = fmt::format(
        "<details class=\"fit\"><summary><span class=\"chip good\">pass</span> "
        "<b>{}</b> <span class=\"words\">{}.</span></summary>\n{}</details>\n",
        counted(static_cast<std::int64_t>(accepted_boards.size()), "nested fit"),
        ranges_of(accepted_boards),
        boards);
  }
  return pooled_paragraph(survey) + frame_paragraph(survey) + refused + panel + boards;
}

}  // namespace panelcal::report
