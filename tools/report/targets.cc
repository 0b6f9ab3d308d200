// SPDX-License-Identifier: Apache-2.0
#include "tools/report/targets.h"

#include <algorithm>
#include <map>
#include <vector>

#include "tools/figures/text.h"
#include "tools/report/input/views.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

/// Up to this number of cards is shown unfolded.
constexpr std::size_t kShownUnfolded = 24;
/// More groups than this go into one fold.
constexpr std::size_t kMaxLooseTargets = 12;

/// x, y and, if it means something, the length.
std::string vector_row(std::string_view name,
                       const Eigen::Vector2d& v_mm,
                       int n_decimals,
                       bool has_length) {
  const Eigen::Vector2d v_um = v_mm * 1e3;
  const auto cell = [&](double value_um) {
    return has_length ? fixed_signed(value_um, n_decimals) : fixed(value_um, n_decimals);
  };
  return fmt::format("<tr><th>{}</th><td>{}</td><td>{}</td><td>{}</td></tr>",
                     name,
                     cell(v_um.x()),
                     cell(v_um.y()),
                     has_length ? fixed(v_um.norm(), n_decimals) : "");
}

std::string crop_picture(const ReportInput& input, const MeasurementRequest& request) {
  const auto crop = input.crops_png.find(request.seq);
  if (crop == input.crops_png.end() || crop->second.empty()) {
    return "<div class=\"nopicture\">no picture</div>";
  }
  return fmt::format(
      "<img tabindex=\"0\" alt=\"target #{} as seen, with the centre found\" "
      "src=\"data:image/png;base64,{}\"/>",
      request.seq,
      base64(crop->second));
}

std::string status_chip(const TargetFact& fact) {
  if (fact.measurement->status != MeasurementStatus::Found) {
    std::string words(name(fact.measurement->status));
    std::ranges::replace(words, '_', ' ');
    return fmt::format("<span class=\"chip refused\">{}</span>", words);
  }
  switch (fact.state) {
    case TargetState::Refused:
      return "<span class=\"chip refused\">residual too large</span>";
    case TargetState::Suspect:
      return fmt::format("<span class=\"chip suspect\">found, {}</span>",
                         fact.series->is_fitted() ? "fit refused" : "no fit");
    case TargetState::Dropped:
      return "<span class=\"chip suspect\">found, left out of the fit</span>";
    case TargetState::Good:
      break;
  }
  return "<span class=\"chip good\">found</span>";
}

std::string measured_table(const TargetFact& fact) {
  const Measurement& m = *fact.measurement;
  if (m.status != MeasurementStatus::Found) return {};
  const Eigen::Vector2d deviation_mm = m.measured.position.in_mm() - m.request.expected.in_mm();
  const Eigen::Vector2d sigma_mm = m.measured.cov.diagonal().cwiseSqrt();
  std::string out = "<table><tr><th>&#181;m</th><th>x</th><th>y</th><th>length</th></tr>" +
                    vector_row("measured &#8722; expected", deviation_mm, 1, true);
  if (fact.residual_mm) out += vector_row("<b>residual</b>", *fact.residual_mm, 2, true);
  out += vector_row("sigma", sigma_mm, 3, false);
  if (m.scatter) out += vector_row("scatter of inspections", m.scatter->in_mm(), 3, false);
  return out + "</table>\n";
}

std::string card(const ReportInput& input, const TargetFact& fact) {
  const Measurement& m = *fact.measurement;
  const std::string path = path_text(m.request.path);
  constexpr std::string_view kClasses[] = {"good", "suspect", "suspect", "refused"};
  std::string out = fmt::format(
      "<article class=\"card {}\" id=\"target-{}\">\n<div class=\"head\">{}<div>"
      "<h4>#{} {} {}</h4><p class=\"quiet\">line {}{}</p>"
      "<p><span class=\"quiet\">nominal</span> {} mm</p>",
      kClasses[static_cast<std::size_t>(fact.state)],
      m.request.seq,
      crop_picture(input, m.request),
      m.request.seq,
      escaped(m.request.command),
      status_chip(fact),
      m.request.line,
      path.empty() ? "" : ", board " + path,
      point_text(m.request.nominal.in_mm()));
  if (m.score)
    out += fmt::format("<p><span class=\"quiet\">score</span> {}</p>", fixed(*m.score, 3));
  if (!m.image.empty()) out += fmt::format("<p class=\"quiet\">{}</p>", escaped(m.image));
  out += "</div></div>\n";
  if (!m.reason.empty()) out += fmt::format("<p class=\"reason\">{}</p>\n", escaped(m.reason));
  out += measured_table(fact);
  if (const auto views = input.views.find(m.request.seq); views != input.views.end()) {
    out += views_figure(m, views->second);
  }
  return out + "</article>\n";
}

using Facts = std::vector<const TargetFact*>;

std::string cards(const ReportInput& input, const Facts& facts) {
  std::string out = "<div class=\"cards\">\n";
  for (const TargetFact* fact : facts) out += card(input, *fact);
  return out + "</div>\n";
}

std::string group_summary(const Facts& facts) {
  double worst_mm = 0;
  bool has_residual = false;
  for (const TargetFact* fact : facts) {
    if (!fact->residual_mm) continue;
    has_residual = true;
    worst_mm = std::max(worst_mm, fact->residual_mm->norm());
  }
  const SeriesResult* series = facts.front()->series;
  std::string out =
      fmt::format("<b>{}</b> <span class=\"quiet\">{}",
                  series == nullptr ? "Measured holes, no part of a fit" : series_name(*series),
                  counted(static_cast<std::int64_t>(facts.size()), "target"));
  if (has_residual) out += fmt::format(", largest residual {} &#181;m", fixed(worst_mm * 1e3, 2));
  return out + "</span>";
}

}  // namespace

std::string target_cards(const ReportInput& input, std::span<const TargetFact> facts) {
  if (facts.empty()) return "<p class=\"quiet\">The program asks for no targets.</p>\n";
  Facts refused;
  Facts dropped;
  Facts suspect;
  std::map<std::size_t, Facts> groups;  // by series, in the order of execution; loose ones last
  for (const TargetFact& fact : facts) {
    if (fact.state == TargetState::Refused) {
      refused.push_back(&fact);
    } else if (fact.state == TargetState::Dropped) {
      dropped.push_back(&fact);
    } else if (fact.state == TargetState::Suspect) {
      suspect.push_back(&fact);
    } else {
      groups[fact.i_series.value_or(SIZE_MAX)].push_back(&fact);
    }
  }
  std::string out;
  if (!refused.empty()) out += "<h3>Refused</h3>\n" + cards(input, refused);
  if (!suspect.empty())
    out += "<h3>Found, but their fit was refused</h3>\n" + cards(input, suspect);
  if (!dropped.empty()) {
    out +=
        "<h3>Found, but left out of their fit ([gates] max_dropped)</h3>\n" + cards(input, dropped);
  }
  const bool is_open = facts.size() <= kShownUnfolded;
  std::string folded;
  for (const auto& [i_series, group] : groups) {
    folded += fmt::format("<details{}><summary>{}</summary>\n{}</details>\n",
                          is_open ? " open=\"open\"" : "",
                          group_summary(group),
                          cards(input, group));
  }
  if (groups.size() <= kMaxLooseTargets) return out + folded;
  const auto n_bad = static_cast<std::int64_t>(refused.size() + suspect.size() + dropped.size());
  return out + fmt::format(
                   "<details><summary><b>{} without complaint</b> "
                   "<span class=\"quiet\">in {}</span></summary>\n{}</details>\n",
                   counted(static_cast<std::int64_t>(facts.size()) - n_bad, "target"),
                   counted(static_cast<std::int64_t>(groups.size()), "group"),
                   folded);
}

}  // namespace panelcal::report
