// SPDX-License-Identifier: Apache-2.0
#include "tools/report/html.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "tools/figures/style.h"
#include "tools/figures/text.h"
#include "tools/report/calibrations.h"
#include "tools/report/figures.h"
#include "tools/report/fits/fits.h"
#include "tools/report/focus.h"
#include "tools/report/input/facts.h"
#include "tools/report/surface/depth.h"
#include "tools/report/surface/depth_map.h"
#include "tools/report/surface/surface.h"
#include "tools/report/targets.h"
#include "tools/report/verdict.h"
#include <fmt/format.h>

namespace panelcal {
namespace report {
namespace {

struct VerdictWords {
  std::string_view word;
  std::string_view symbol;
  std::string_view css_class;
};

VerdictWords verdict_words(Verdict verdict) {
  switch (verdict) {
    case Verdict::Drill:
      return {"DRILL", "&#10003;", "drill"};
    case Verdict::Warned:
      return {"DRILL, WITH A WARNING", "&#9888;", "forced"};
    case Verdict::Hold:
      return {"HOLD", "&#10007;", "hold"};
    case Verdict::Forced:
      break;
  }
  return {"FORCED", "&#9888;", "forced"};
}

std::string report_tile(std::string_view name, std::string_view value, std::string_view remark) {
  return fmt::format("<div><dt>{}</dt><dd>{}<small>{}</small></dd></div>\n", name, value, remark);
}

std::string meter(const WorstGate& worst) {
  return fmt::format("<span class=\"meter {}\"><span style=\"width:{:.0f}%\"></span></span>",
                     worst.gate->accepted ? "good" : "refused",
                     100 * std::clamp(worst.ratio, 0.0, 1.0));
}

std::string percent_of_limit(const WorstGate& worst) {
  const std::string limit = gate_limit(*worst.gate);
  if (!(worst.ratio < 100)) return "far beyond the limit, " + limit;
  return fmt::format("{:.0f} % of the limit, {}", 100 * worst.ratio, limit);
}

std::string target_link(const Measurement& measurement) {
  return fmt::format("target <a href=\"#target-{0}\">#{0}</a>", measurement.request.seq);
}

std::string residual_tile(const Survey& survey, std::span<const TargetFact> facts) {
  constexpr std::string_view kName = "worst residual against its limit";
  const std::optional<WorstGate> worst = worst_gate(survey, GateKind::Residual);
  if (worst && worst->gate->i_target && *worst->gate->i_target < worst->series->points.size()) {
    const std::size_t i = worst->series->points[*worst->gate->i_target];
    return report_tile(
        kName,
        gate_value(*worst->gate),
        meter(*worst) + percent_of_limit(*worst) + "; " + target_link(survey.measurements[i]));
  }
  const TargetFact* largest = nullptr;
  for (const TargetFact& fact : facts) {
    if (!fact.residual_mm) continue;
    if (largest == nullptr || fact.residual_mm->norm() > largest->residual_mm->norm()) {
      largest = &fact;
    }
  }
  if (largest == nullptr) return report_tile(kName, "none", "nothing was fitted");
  return report_tile(kName,
                     fixed(largest->residual_mm->norm() * 1e3, 2) + " &#181;m",
                     target_link(*largest->measurement) + "; no limit is set");
}

std::string other_gate_tile(const Survey& survey) {
  const std::optional<WorstGate> worst = worst_gate(survey, GateKind::Other);
  if (!worst) return {};
  const GateVerdict& gate = *worst->gate;
  return report_tile(
      fmt::format("worst other gate: {}", escaped(gate.gate)),
      gate_value(gate),
      meter(*worst) + percent_of_limit(*worst) + "; " + escaped(series_name(*worst->series)));
}

std::string um_1(Length length) {
  return shortest(std::round(length.in_um() * 10) / 10) + " &#181;m";
}

std::string hole_tiles(const ReportInput& input) {
  const Tally* tally = input.tally;
  if (tally == nullptr) return report_tile("holes", "none written", "the program was refused");
  std::string out =
      report_tile("holes",
                  grouped(tally->n_holes()),
                  counted(static_cast<std::int64_t>(tally->holes_by_tool().size()), "tool"));
  if (!survey_of(input).measurements.empty()) {
    out += report_tile("largest shift", um_1(tally->max_shift()), "nominal to corrected");
    out += report_tile("largest predicted sigma",
                       fixed(tally->max_sigma().in_um(), 3) + " &#181;m",
                       input.unstated.empty() ? "one standard deviation, worst direction"
                                              : "of the fit only: " + escaped(input.unstated));
  }
  if (input.truth != nullptr && input.truth->all().corrected.n > 0) {
    out += report_tile("largest error against truth",
                       fixed(input.truth->all().corrected.max().in_um(), 2) + " &#181;m",
                       um_1(input.truth->all().uncorrected.max()) + " without correction");
  }
  return out;
}

std::string tolerance_tile(const JobVerdict* verdict) {
  if (verdict == nullptr || verdict->n_judged() == 0) return {};
  if (verdict->basis().kind != RiskBasis::Kind::Stated) {
    return report_tile("risk of breaking a tolerance",
                       verdict->basis().tells_risk()
                           ? "at least " + risk_html(verdict->worst_tool()->stated_risk)
                           : "no figure",
                       "<a href=\"#tolerance\">why</a>: " + escaped(verdict->basis().words));
  }
  return report_tile("places expected to break their tolerance",
                     risk_text(verdict->expected_broken()),
                     fmt::format("of {}; <a href=\"#tolerance\">worst risk</a> {}",
                                 grouped(verdict->n_judged()),
                                 risk_text(verdict->worst_tool()->worst.risk)));
}

std::string left_out_of_fits_text(std::size_t n) {
  if (n == 0) return {};
  return fmt::format("; <span class=\"chip suspect\">{} left out of {}</span>",
                     n,
                     n == 1 ? "its fit" : "their fits");
}

std::string first_screen(const ReportInput& input, std::span<const TargetFact> facts) {
  const VerdictWords words = verdict_words(verdict_of(input));
  const Survey& survey = survey_of(input);
  std::string out = fmt::format(
      "<h1><b>{}</b> on {}; measured from {}; {}</h1>\n"
      "<div class=\"verdict {}\">\n<div class=\"top\"><div class=\"word\">{} "
      "{}</div><p>{}</p></div>\n"
      "<p class=\"next\"><b>Next:</b> {}</p>\n<dl class=\"tiles\">\n",
      escaped(input.program_file),
      escaped(input.machine_name),
      escaped(input.source),
      input.output_file.empty()  ? "nothing written"
      : input.output_file == "-" ? "written to standard output"
                                 : "written to " + escaped(input.output_file),
      words.css_class,
      words.symbol,
      words.word,
      escaped(verdict_sentence(input)),
      escaped(next_step(input)));
  if (!survey.measurements.empty()) {
    out += residual_tile(survey, facts) + other_gate_tile(survey) +
           report_tile("targets found",
                       fmt::format("{} of {}", n_found(survey), survey.measurements.size()),
                       counted(static_cast<std::int64_t>(survey.series.size()), "fit") +
                           left_out_of_fits_text(n_dropped(survey)));
  }
  return out + hole_tiles(input) + tolerance_tile(input.verdict) + depth_tile(input.depth) +
         "</dl>\n</div>\n";
}

std::string messages(std::span<const Diagnostic> diagnostics) {
  if (diagnostics.empty()) return "<p class=\"quiet\">No errors and no warnings.</p>\n";
  std::vector<const Diagnostic*> ordered;
  for (const Diagnostic& diagnostic : diagnostics) ordered.push_back(&diagnostic);
  const auto is_error = [](const Diagnostic* d) { return d->severity() == Severity::Error; };
  std::stable_partition(ordered.begin(), ordered.end(), is_error);
  std::string out = "<ul class=\"messages\">\n";
  for (const Diagnostic* diagnostic : ordered) {
    out += fmt::format(
        "<li><span class=\"chip {0}\">{0}</span> <code>{1}</code><br/>"
        "<span class=\"quiet\">{2}</span></li>\n",
        is_error(diagnostic) ? "error" : "warning",
        escaped(diagnostic->text()),
        escaped(info(diagnostic->code).advice));
  }
  return out + "</ul>\n";
}

std::string truth_row(std::string_view name, const TruthComparison::Errors& errors) {
  return fmt::format(
      "<tr><td>{}</td><td class=\"num\">{}</td><td class=\"num\">{}</td><td class=\"num\">{}</td>"
      "<td class=\"num\"><b>{}</b></td><td class=\"num\"><b>{}</b></td></tr>\n",
      name,
      grouped(errors.corrected.n),
      fixed(errors.uncorrected.max().in_um(), 1),
      fixed(errors.uncorrected.rms().in_um(), 1),
      fixed(errors.corrected.max().in_um(), 3),
      fixed(errors.corrected.rms().in_um(), 3));
}

std::string truth_section(const TruthComparison& truth) {
  std::string out =
      "<h2 id=\"truth\">Errors against truth</h2>\n<section><div class=\"scroll\">"
      "<table class=\"grid\"><tr><th>tool</th><th class=\"num\">holes</th><th "
      "class=\"num\">uncorrected, largest &#181;m</th>"
      "<th class=\"num\">r.m.s. &#181;m</th><th class=\"num\">corrected, largest &#181;m</th><th "
      "class=\"num\">r.m.s. &#181;m</th></tr>\n";
  for (const auto& [tool, errors] : truth.by_tool())
    out += truth_row(fmt::format("T{}", tool), errors);
  out += truth_row("all", truth.all()) + "</table></div>\n";
  if (const double square = truth.mean_normalized_square(); square > 0) {
    out += fmt::format(
        "<p class=\"quiet\">Mean squared error over the variance that the targets' pictures "
        "predict: "
        "{}. It is near 1 over many jobs if that prediction is honest; the holes of one job share "
        "their fits, so one job scatters widely. Sigma also holds what the machine's file states "
        "of "
        "the spindle-camera offset and its drift, the camera, the stage, the table and the drill: "
        "a "
        "simulation draws none of these, so they are not counted here.</p>\n",
        fixed(square, 2));
  }
  return out + "</section>\n";
}

std::string foot(const ReportInput& input) {
  std::string out =
      "<footer>\n<p>Nominal (as programmed, after step and repeat), expected (where the camera "
      "looked) and measured places are relative to work zero, x right, y up, in mm; 1000 &#181;m = "
      "1 mm. Angles count counter-clockwise; 1 mrad turns 100 mm by 100 &#181;m; 1 ppm stretches "
      "100 mm by 0.1 &#181;m. A sigma, and what follows &#177;, is one standard deviation. "
      "Residual: "
      "measured minus fitted. p: the chance that noise of the stated size alone gives at least "
      "this chi square.</p>\n<dl>\n";
  for (const auto& [key, value] : input.provenance) {
    out += fmt::format("<dt>{}</dt><dd class=\"mono\">{}</dd>\n", escaped(key), escaped(value));
  }
  return out + "</dl>\n</footer>\n";
}

}  // namespace
}  // namespace report

std::string report_html(const ReportInput& input) {
  using namespace report;
  const std::vector<TargetFact> facts = target_facts(survey_of(input));
  std::string out = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head>\n"
      "<meta charset=\"utf-8\"/>\n<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\"/>\n<title>{}: {} - "
      "panelcal</title>\n<style>{}{}</style>\n</head>\n<body>\n"
      "<main>\n",
      verdict_words(verdict_of(input)).word,
      escaped(input.program_file),
      kStyle,
      depth_map_style(input.depth));
  out += first_screen(input, facts);
  out += verdict_section(input);
  out += depth_section(input.depth);
  out += "<h2>Panel</h2>\n<section>\n" + panel_figures(input, facts) + "</section>\n";
  out += "<h2>Fiducials</h2>\n<section>\n" + target_cards(input, facts) + "</section>\n";
  out += "<h2>Fits</h2>\n<section>\n" + fits_section(input) + "</section>\n";
  out += budget_section(input.worst_hole);
  out += calibrations_section(survey_of(input));
  out += focus_section(survey_of(input));
  out += surface_section(survey_of(input), input.surface_use);
  out += "<h2>Messages</h2>\n<section>\n" + messages(input.diagnostics) + "</section>\n";
  if (input.truth != nullptr) out += truth_section(*input.truth);
  return out + foot(input) + "</main>\n</body>\n</html>\n";
}

}  // namespace panelcal
