// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string_view>

#include "calib/base/clock.h"
#include "calib/drift/amount.h"
#include "tools/figures/contour_map.h"
#include "tools/figures/style.h"
#include "tools/figures/text.h"
#include "tools/nightly/figures.h"
#include "tools/nightly/report.h"
#include "tools/nightly/surface.h"
#include <fmt/format.h>

namespace panelcal::nightly {
namespace {

using report::counted;
using report::escaped;

constexpr std::string_view kNightlyPageStyle = R"css(
h2 .chip{margin-left:8px;vertical-align:2px}
ul.plain{margin:6px 0;padding-left:20px}ul.plain li{margin:3px 0}
p.alarm{color:var(--bad);font-weight:600}
td .chip{min-width:62px;text-align:center}
pre{white-space:pre-wrap;margin:6px 0;font-size:12.5px}
.legend .mark-in{width:16px;height:12px;vertical-align:-1px}
)css";

/// "installed": good, "kept old": a warning, the rest bad.
std::string_view css_of(NightState state) {
  switch (state) {
    case NightState::Installed:
      return "";
    case NightState::KeptOld:
    case NightState::WouldRun:
      return " warning";
    case NightState::Held:
    case NightState::Failed:
    case NightState::NotReached:
      break;
  }
  return " refused";
}

std::string chip(std::string_view css, std::string_view text) {
  return fmt::format("<span class=\"chip{}\">{}</span>", css, escaped(text));
}

std::string night_list(const std::vector<std::string>& lines) {
  if (lines.empty()) return {};
  std::string out = "<ul class=\"plain\">\n";
  for (const std::string& line : lines) out += "<li>" + escaped(line) + "</li>\n";
  return out + "</ul>\n";
}

std::string night_tile(std::string_view term, std::string_view value, std::string_view detail) {
  return fmt::format("<div><dt>{}</dt><dd>{}<small>{}</small></dd></div>\n",
                     escaped(term),
                     escaped(value),
                     escaped(detail));
}

std::string until_text(const NightRecord& record) {
  if (!record.may_drill) return "do not drill";
  return record.drill_until ? minute_text(*record.drill_until) : "no end predicted";
}

std::string steps_text(const NightRecord& record) {
  std::string out;
  for (const NightState state : {NightState::Installed,
                                 NightState::KeptOld,
                                 NightState::Held,
                                 NightState::Failed,
                                 NightState::NotReached,
                                 NightState::WouldRun}) {
    const auto n = std::ranges::count(record.steps, state, &NightStep::state);
    if (n > 0) out += fmt::format("{}{} {}", out.empty() ? "" : ", ", n, name(state));
  }
  return out.empty() ? "none" : out;
}

/// Of a night that probed the table.
std::string surface_tile(const NightRecord& record) {
  const auto step = std::ranges::find(record.steps, word(LedgerKind::Surface), &NightStep::kind);
  if (step == record.steps.end() || step->axes.empty() || !step->axes.front().new_value) return {};
  const std::string& unit = step->axes.front().unit;
  if (!step->change) return night_tile("table's surface", "mapped", "for the first time");
  return night_tile("table's surface",
                    amount(*step->change, unit) + " moved",
                    fmt::format("sigma {}, by all its figures", amount(*step->change_sigma, unit)));
}

std::string night_tiles(const NightRecord& record) {
  const auto n_checks = static_cast<std::int64_t>(record.checks.size());
  const auto n_passed = std::ranges::count(record.checks, true, &SelfTestCheck::passed);
  std::string temperature = "not known";
  if (record.temperature_c) temperature = report::fixed(*record.temperature_c, 1) + " degC";
  return "<dl class=\"tiles\">\n" +
         night_tile(
             "may drill until",
             until_text(record),
             record.may_drill ? "or until the next report" : "until an operator has confirmed") +
         night_tile("calibrations", steps_text(record), "what became of them") +
         night_tile("self-test",
                    fmt::format("{} of {}", n_passed, n_checks),
                    n_passed == n_checks ? "checks passed" : "checks passed: see below") +
         surface_tile(record) + night_tile("temperature", temperature, "of the machine") +
         "</dl>\n";
}

/// The next step of a person; empty if all is well.
std::string next_step(const NightRecord& record) {
  if (record.is_dry_run)
    return "Nothing was moved, measured or written: this is what would be done.";
  if (record.outcome == NightOutcome::AllInstalled && record.may_drill) return {};
  const std::string again = fmt::format("panelcal nightly -m {}", record.config_file.string());
  if (record.outcome == NightOutcome::Failed) {
    return "Repair the failed device or file, then run " + again + ": it goes on where it stopped.";
  }
  if (record.may_drill) {
    return "Drill with the calibrations in force, and examine the refused one before they expire.";
  }
  return "The first red line names the part to inspect. After a repair, run " + again +
         " --again; after an intended change, record it with panelcal history fresh-start first.";
}

std::string verdict(const NightRecord& record) {
  const bool is_good = record.may_drill && record.outcome == NightOutcome::AllInstalled;
  const std::string_view css = !record.may_drill ? " hold" : is_good ? "" : " forced";
  std::string_view word = record.may_drill ? "DRILL" : "HOLD";
  if (record.is_dry_run) word = "DRY RUN";
  std::string out = fmt::format(
      "<div class=\"verdict{}\">\n<div class=\"top\"><div class=\"word\">{}</div><p>{}</p></div>\n",
      record.is_dry_run ? " forced" : css,
      word,
      escaped(record.verdict));
  if (const std::string next = next_step(record); !next.empty()) {
    out += "<p class=\"next\"><b>Next:</b> " + escaped(next) + "</p>\n";
  }
  return out + night_tiles(record) + "</div>\n";
}

std::string changes(const NightRecord& record) {
  return "<h2>Since last week</h2>\n<section>\n" +
         (record.changes.empty()
              ? std::string("<p class=\"quiet\">Nothing to compare with: no calibration of a week "
                            "ago is known.</p>\n")
              : night_list(record.changes)) +
         "</section>\n";
}

/// An absolute value, with the digits that matter on a machine.
std::string value_text(const std::optional<double>& value, const std::string& unit) {
  if (!value) return "-";
  if (unit == "mm") return report::fixed(*value, 4) + " mm";
  return report::shortest(*value) + " " + unit;
}

/// Not as a ratio: what is predicted has wider tails than a normal distribution, which the gates
/// count and a quotient would not.
std::string surprise_text(const NightStep& step, const NightAxis& axis) {
  if (!step.series.empty() && step.series.back().is_fresh_start) return "fresh start";
  if (!axis.new_value || !axis.expected || !axis.expected_sigma) return "-";
  return fmt::format("{} (predicted to {})",
                     signed_amount(*axis.new_value - *axis.expected, axis.unit),
                     amount(*axis.expected_sigma, axis.unit));
}

std::string axes(const NightStep& step) {
  if (step.axes.empty()) return {};
  std::string out =
      "<div class=\"scroll\"><table class=\"grid\"><tr><th>axis</th><th class=\"num\">old</th>"
      "<th class=\"num\">new</th><th class=\"num\">sigma</th><th class=\"num\">change</th>"
      "<th class=\"num\">off the prediction</th></tr>\n";
  for (const NightAxis& axis : step.axes) {
    const bool has_both = axis.old_value && axis.new_value;
    out += "<tr><td>" + escaped(axis.name) + "</td>";
    for (const std::string& cell :
         {value_text(axis.old_value, axis.unit),
          value_text(axis.new_value, axis.unit),
          axis.new_sigma ? amount(*axis.new_sigma, axis.unit) : std::string("-"),
          has_both ? signed_amount(*axis.new_value - *axis.old_value, axis.unit) : std::string("-"),
          surprise_text(step, axis)}) {
      out += "<td class=\"num\">" + escaped(cell) + "</td>";
    }
    out += "</tr>\n";
  }
  return out + "</table></div>\n";
}

std::string gates(const NightStep& step) {
  if (!step.decision || step.decision->gates.empty()) return {};
  std::string out = "<h3>Gates</h3>\n<div class=\"scroll\"><table class=\"grid\">\n";
  for (const NightGate& gate : step.decision->gates) {
    out += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                       chip(gate.passed ? "" : " refused", gate.passed ? "passed" : "refused"),
                       escaped(gate.name),
                       escaped(gate.text));
  }
  return out + "</table></div>\n";
}

std::string qualities(const NightStep& step) {
  if (step.qualities.empty()) return {};
  std::string out =
      "<h3>How well it could measure</h3>\n<div class=\"scroll\"><table class=\"grid\">\n";
  for (const NightQuality& quality : step.qualities) {
    out += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n",
        chip(quality.is_alarm ? " refused" : "", quality.is_alarm ? "unusual" : "usual"),
        escaped(quality.name),
        escaped(quality.text));
  }
  return out + "</table></div>\n";
}

std::string legend() {
  constexpr std::string_view kSample =
      "<li><svg class=\"drift mark-in\" style=\"display:inline-block;width:18px\" "
      "xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 18 12\">{}</svg> {}</li>\n";
  std::string out = "<ul class=\"legend\">\n";
  for (const auto& [sample, text] : {
           std::pair("<path class=\"night\" d=\"M9 0V12\"/><circle class=\"dot\" cx=\"9\" "
                     "cy=\"6\" r=\"2.4\"/>",
                     "a night, one sigma to either side"),
           std::pair("<path class=\"refused\" d=\"M5 2l8 8m0 -8l-8 8\"/>", "refused"),
           std::pair("<circle class=\"ring\" cx=\"9\" cy=\"6\" r=\"5\"/>", "alarm"),
           std::pair("<path class=\"force\" d=\"M0 6H18\"/>", "in force"),
           std::pair("<path class=\"fresh\" d=\"M9 0V12\"/>", "fresh start"),
           std::pair("<rect class=\"band\" x=\"4\" y=\"1\" width=\"10\" height=\"10\"/>",
                     "tonight as predicted, three sigma"),
       }) {
    out += fmt::format(fmt::runtime(kSample), sample, text);
  }
  return out + "</ul>\n";
}

std::string step_figures(const NightStep& step) {
  std::string charts;
  for (std::size_t i = 0; i < step.axes.size(); ++i) charts += drift_figure(step, i);
  const std::string holes = holes_figure(step);
  std::string out = surface_figures(step);
  if (!charts.empty()) {
    out += fmt::format("<h3>The last {}</h3>\n<div class=\"charts\">\n{}</div>\n",
                       counted(static_cast<std::int64_t>(step.series.size()), "night"),
                       charts) +
           legend();
  }
  return holes.empty() ? out : out + "<div class=\"charts\">\n" + holes + "</div>\n";
}

std::string small_print(const NightStep& step) {
  std::vector<std::string> facts;
  if (step.ledger_id) facts.push_back(fmt::format("entry {} of the ledger", *step.ledger_id));
  if (step.in_force_id) facts.push_back(fmt::format("in force: entry {}", *step.in_force_id));
  if (!step.file.empty()) facts.push_back("file " + step.file.string());
  if (step.is_from_earlier_run) facts.emplace_back("measured by an earlier run of this night");
  std::string out;
  if (!facts.empty()) {
    out += "<p class=\"quiet\">" + escaped(fmt::format("{}", fmt::join(facts, "; "))) + "</p>\n";
  }
  if (step.fit_report.empty()) return out;
  out += "<details><summary>The fit in full</summary><pre class=\"mono\">";
  for (const std::string& line : step.fit_report) out += escaped(line) + "\n";
  return out + "</pre></details>\n";
}

std::string reasons(const NightStep& step) {
  std::string out;
  if (step.problem) out += "<p class=\"reason\">" + escaped(step.problem->text()) + "</p>\n";
  const auto is_said = [&](const std::string& reason) {
    return step.summary.find(reason) != std::string::npos;
  };
  if (step.decision && step.decision->verdict != NightVerdict::Install &&
      !std::ranges::all_of(step.decision->reasons, is_said)) {
    out += night_list(step.decision->reasons);
  }
  for (const std::string& alarm : step.alarms) {
    out += "<p class=\"alarm\">" + escaped(alarm) + "</p>\n";
  }
  if (!step.since_when.empty()) out += "<p>" + escaped(step.since_when) + "</p>\n";
  if (!step.forecast_text.empty()) {
    // If tonight speaks against what is in force, the nights before it are no answer.
    const bool is_held = step.state == NightState::Held;
    out += fmt::format("<p><b>{}</b> {}</p>\n",
                       is_held ? "By the nights before alone:" : "May it be used?",
                       escaped(step.forecast_text));
  }
  return out;
}

std::string night_section(const NightStep& step) {
  return fmt::format("<h2>{} {}{}</h2>\n<section>\n",
                     escaped(step.kind),
                     escaped(step.subject),
                     chip(css_of(step.state), name(step.state))) +
         (step.summary.empty() ? std::string() : "<p>" + escaped(step.summary) + "</p>\n") +
         reasons(step) + axes(step) + gates(step) + qualities(step) + step_figures(step) +
         small_print(step) + "</section>\n";
}

std::string self_test(const NightRecord& record) {
  if (record.checks.empty()) return {};
  std::string out = "<h2>Self-test</h2>\n<section>\n<div class=\"scroll\"><table class=\"grid\">\n";
  for (const SelfTestCheck& check : record.checks) {
    out += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                       chip(check.passed ? "" : " refused", check.passed ? "passed" : "failed"),
                       escaped(check.name),
                       escaped(check.text));
  }
  return out + "</table></div>\n</section>\n";
}

std::string warm_up(const NightRecord& record) {
  if (!record.warm_up) return {};
  const NightWarmUp& seen = *record.warm_up;
  return fmt::format(
      "<h2>Warming up{}</h2>\n<section>\n<p>{}</p>\n<div class=\"charts\">\n{}"
      "</div>\n</section>\n",
      chip(seen.is_warm ? "" : " refused", seen.is_warm ? "warm" : "not known"),
      escaped(seen.text),
      warm_up_figure(seen));
}

std::string footer(const NightRecord& record, const Provenance& provenance) {
  Provenance rows = {{"started", iso_8601(record.started)},
                     {"finished", iso_8601(record.finished)},
                     {"asked by", record.asked_by},
                     {"made by", record.software},
                     {"machine file", record.config_file.string()},
                     {"ledger", record.ledger_file.string()}};
  if (record.head.id > 0) {
    rows.emplace_back("ledger head", fmt::format("{} {}", record.head.id, record.head.hash));
  }
  rows.insert(rows.end(), provenance.begin(), provenance.end());
  std::string out = "<footer>\n<dl>\n";
  for (const auto& [key, value] : rows) {
    if (value.empty()) continue;
    out += fmt::format("<dt>{}</dt><dd class=\"mono\">{}</dd>\n", escaped(key), escaped(value));
  }
  return out + "</dl>\n</footer>\n";
}

}  // namespace

std::string night_html(const NightRecord& record, const Provenance& provenance) {
  std::string out = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head>\n"
      "<meta charset=\"utf-8\"/>\n<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\"/>\n<title>{0} {1}: {2} - panelcal</title>\n<style>{3}{4}{5}</style>\n"
      "</head>\n<body>\n<main>\n<h1>Night of <b>{1}</b> on <b>{0}</b></h1>\n",
      escaped(record.machine),
      escaped(record.night),
      record.may_drill ? "drill" : "hold",
      report::kStyle,
      kFigureStyle,
      std::string(contours::kContourStyle) + std::string(kNightlyPageStyle));
  out += verdict(record) + changes(record);
  if (!record.notes.empty()) {
    out += "<h2>Notes</h2>\n<section>\n" + night_list(record.notes) + "</section>\n";
  }
  for (const NightStep& step : record.steps) out += night_section(step);
  return out + warm_up(record) + self_test(record) + footer(record, provenance) +
         "</main>\n</body>\n</html>\n";
}

}  // namespace panelcal::nightly
