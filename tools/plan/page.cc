// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/page.h"

#include <algorithm>
#include <numeric>

#include "tools/figures/style.h"
#include "tools/figures/text.h"
#include "tools/plan/advice.h"
#include "tools/plan/map.h"
#include "tools/plan/text.h"
#include <fmt/format.h>

namespace panelcal::plan {
namespace {

using report::escaped;

constexpr double kMapGap = 16;

constexpr std::string_view kPlanPageStyle = R"css(
.maps{display:grid;grid-template-columns:repeat(auto-fit,minmax(330px,1fr));gap:14px;align-items:start;margin:12px 0}
.maps svg{width:100%;height:auto;border-radius:8px;border:1px solid var(--line)}
table.grid tr.now td{font-weight:650}table.grid tr.now td:first-child::before{content:"\25B8\00A0"}
ul.advice{margin:10px 0 0;padding-left:20px}ul.advice li{margin:4px 0}
)css";

std::vector<Drawing> maps_of(const SeriesPlan& series) {
  std::vector<Drawing> maps = {leverage_drawing(series, nullptr)};
  for (const auto* addition : {&series.one, &series.several}) {
    if (*addition && (*addition)->fit) maps.push_back(leverage_drawing(series, &**addition));
  }
  std::erase_if(maps, [](const Drawing& drawing) { return drawing.content.empty(); });
  return maps;
}

std::string standalone(const Drawing& drawing, std::string_view label) {
  return fmt::format(
      "<svg class=\"plan\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0f} {:.0f}\" "
      "style=\"max-width:{:.0f}px\" role=\"img\" aria-label=\"{}\">\n{}</svg>\n",
      drawing.width,
      drawing.height,
      drawing.width,
      label,
      drawing.content);
}

std::string plan_table_html(const Plan& plan, const SeriesPlan& series) {
  std::string out =
      "<div class=\"scroll\"><table class=\"grid\"><tr><th>model</th><th class=\"num\">d.o.f.</th>"
      "<th class=\"num\">worst, times the noise</th><th class=\"num\">&#181;m</th>"
      "<th class=\"num\">total &#181;m</th><th class=\"num\">mean</th>"
      "<th class=\"num\">noticed from &#181;m</th><th>the worst is at</th></tr>\n";
  for (const ModelRow& row : model_rows(plan, series)) {
    out += fmt::format("<tr{}><td>{}</td>", row.is_programmed ? " class=\"now\"" : "", row.model);
    if (!row.why_not.empty()) {
      out += fmt::format("<td colspan=\"7\" class=\"quiet\">{}</td></tr>\n", row.why_not);
      continue;
    }
    for (const std::string* cell :
         {&row.left, &row.worst, &row.worst_um, &row.total_um, &row.mean, &row.noticed}) {
      out += fmt::format("<td class=\"num\">{}</td>", *cell);
    }
    out += fmt::format("<td>{}</td></tr>\n", escaped(row.place));
  }
  return out + "</table></div>\n";
}

std::string error_table_html(const SeriesPlan& series) {
  if (series.errors.empty() || series.errors.size() > kMostListedErrors) return {};
  std::string out =
      "<div class=\"scroll\"><table class=\"grid\"><tr><th>an error of one target</th>"
      "<th class=\"num\">noticed from &#181;m</th><th>by</th><th class=\"num\">named</th>"
      "<th class=\"num\">named at twice</th></tr>\n";
  for (const ErrorRow& row : error_rows(series)) {
    out += fmt::format(
        "<tr><td>{}</td><td class=\"num\">{}</td><td>{}</td><td class=\"num\">{}</td>"
        "<td class=\"num\">{}</td></tr>\n",
        escaped(row.target),
        row.noticed,
        row.by,
        row.named,
        row.named_at_twice);
  }
  return out + "</table></div>\n";
}

std::string advice_list(const std::vector<std::string>& lines) {
  std::string out = "<ul class=\"advice\">\n";
  for (const std::string& line : lines) out += "<li>" + escaped(line) + "</li>\n";
  return out + "</ul>\n";
}

std::string series_section(const Plan& plan, const SeriesPlan& series) {
  std::string out = "<h2>" + escaped(series_title(plan, series)) + "</h2>\n<section>\n";
  if (const std::string note = series_note(plan, series); !note.empty()) {
    out += "<p class=\"quiet\">" + escaped(note) + "</p>\n";
  }
  out += advice_list(series_advice(plan, series)) + "<div class=\"maps\">\n";
  for (const Drawing& map : maps_of(series)) out += standalone(map, "Leverage over the panel");
  out += "</div>\n" + standalone(scale_drawing(series), "Colours and their leverages");
  return out +
         "<p class=\"quiet\">Colour: how much of the noise of one target reaches a hole there, in "
         "its "
         "worst direction; the line of 1 is green. Rings with a cross: targets, dashes: their "
         "hull; "
         "blue: pads to add; red: the worst place.</p>\n" +
         plan_table_html(plan, series) + error_table_html(series) + "</section>\n";
}

}  // namespace

std::string plan_svg(const Plan& plan, const PlanPage& page) {
  constexpr double kHead = 44;
  std::string content;
  double y = kHead;
  double width = 600;
  const auto row = [&](std::string_view title, const std::vector<Drawing>& drawings) {
    content += fmt::format(
        "<text class=\"title\" x=\"{0:.0f}\" y=\"{1:.0f}\">{2}</text>\n", kMapGap, y + 16, title);
    y += 24;
    double x = kMapGap;
    double height = 0;
    for (const Drawing& drawing : drawings) {
      content += fmt::format(
          "<g transform=\"translate({:.0f} {:.0f})\">\n{}</g>\n", x, y, drawing.content);
      x += drawing.width + kMapGap;
      height = std::max(height, drawing.height);
    }
    width = std::max(width, x);
    y += height + kMapGap;
  };
  for (const SeriesPlan& series : plan.series) {
    row(escaped(series_title(plan, series)), maps_of(series));
    y -= kMapGap;
    row("", {scale_drawing(series)});
  }
  if (const Drawing visits = visits_drawing(plan); !visits.content.empty()) {
    row("All targets", {visits});
  }
  std::string description;
  for (const auto& [key, value] : page.provenance) {
    description += escaped(key + ": " + value) + "\n";
  }
  return fmt::format(
      "<svg class=\"plan\" xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" "
      "viewBox=\"0 0 {0:.0f} {1:.0f}\">\n<title>{2}</title>\n<desc>{3}</desc>\n<style>{4}</style>\n"
      "<rect class=\"paper\" width=\"100%\" height=\"100%\"/>\n"
      "<text class=\"title\" x=\"{5:.0f}\" y=\"30\" "
      "style=\"font-size:18px\">{2}</text>\n{6}</svg>\n",
      width,
      y,
      escaped("Plan of " + page.program_file),
      description,
      kPlanStyle,
      kMapGap,
      content);
}

std::string plan_html(const Plan& plan, const Survey& survey, const PlanPage& page) {
  std::string notes;
  for (const std::string& note : {model_text(plan), errors_text(plan)}) {
    if (note.empty()) continue;
    notes += " " + escaped(with_capital(note)) + (note.ends_with('.') ? "" : ".");
  }
  std::string out = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head>\n"
      "<meta charset=\"utf-8\"/>\n<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\"/>\n<title>Plan: {0} - "
      "panelcal</title>\n<style>{1}{2}{3}</style>\n</head>\n"
      "<body>\n<main>\n<h1>Plan of <b>{0}</b>{4}</h1>\n<section>\n<p "
      "class=\"quiet\">{5}.{6}</p>\n</section>\n",
      escaped(page.program_file),
      report::kStyle,
      kPlanStyle,
      kPlanPageStyle,
      page.machine_name.empty() ? "" : " on <b>" + escaped(page.machine_name) + "</b>",
      escaped(noise_text(plan)),
      notes);
  for (const SeriesPlan& series : plan.series) out += series_section(plan, series);
  if (const auto visits = visit_advice(plan, survey); !visits.empty()) {
    out += "<h2>Order of visits</h2>\n<section>\n" + advice_list(visits) +
           "<div class=\"maps\">\n" + standalone(visits_drawing(plan), "The order of visits") +
           "</div>\n</section>\n";
  }
  out += "<footer>\n<dl>\n";
  for (const auto& [key, value] : page.provenance) {
    out += fmt::format("<dt>{}</dt><dd class=\"mono\">{}</dd>\n", escaped(key), escaped(value));
  }
  return out + "</dl>\n</footer>\n</main>\n</body>\n</html>\n";
}

}  // namespace panelcal::plan
