// SPDX-License-Identifier: Apache-2.0
#include "tools/report/fits/models.h"

#include <algorithm>
#include <map>

#include "calib/panel/model_choice.h"
#include "tools/figures/text.h"
#include <fmt/format.h>

namespace panelcal::report {
namespace {

double least_criterion(const std::vector<ModelScore>& scores) {
  return std::ranges::min_element(scores, {}, &ModelScore::criterion)->criterion;
}

std::string left_out_error_text(const ModelScore& score) {
  return score.left_out_mm ? fixed(*score.left_out_mm * 1e3, 2) : "not defined";
}

bool is_of(const ModelScore& score, const SeriesResult& series) {
  return score.is_smooth == series.is_smooth() && score.model == series.model;
}

std::string model_row(const ModelScore& score, const SeriesResult& series, double least) {
  const bool is_in_force = is_of(score, series);
  std::string marks;
  if (is_in_force) marks += "<span class=\"chip good\">in force</span> ";
  if (score.is_chosen && !is_in_force) {
    marks += "<span class=\"chip suspect\">the targets speak for it</span> ";
  }
  if (!score.is_eligible && !score.is_smooth) {
    marks += "<span class=\"quiet\">nothing to check it with</span>";
  }
  return fmt::format(
      "<tr><td>{}</td><td class=\"num\">{}</td><td class=\"num\">{}</td><td class=\"num\">{}</td>"
      "<td class=\"num\">{}</td><td>{}</td></tr>\n",
      name(score),
      fixed(score.parameters, score.is_smooth ? 1 : 0),
      fixed(score.chi_square, 2),
      fixed_signed(score.criterion - least, 2),
      left_out_error_text(score),
      marks);
}

/// "a smooth model would predict left-out targets to 8.10 um instead of 17.30 um"
std::string smooth_gain(const ModelScore& smooth, const ModelScore& best, const char* um) {
  return fmt::format("a smooth model would predict left-out targets to {} {} instead of {} {}",
                     fixed(*smooth.left_out_mm * 1e3, 2),
                     um,
                     fixed(*best.left_out_mm * 1e3, 2),
                     um);
}

std::string advice(const SeriesResult& series) {
  std::string out;
  const ModelScore* best = chosen(series.compared);
  if (best != nullptr && !series.is_smooth() && !is_of(*best, series)) {
    out += fmt::format(
        "<p>The targets speak for the model \"{}\"; the fit is \"{}\" because the machine's file "
        "or the manual prescribes it. <code>[vision] model = \"auto\"</code> would take the "
        "former.</p>\n",
        name(*best),
        name(series.model));
  }
  const ModelScore* smooth = recommended_smooth(series.compared);
  if (smooth != nullptr && !series.is_smooth()) {
    out += fmt::format(
        "<p>The panel is bent: {}. The fit is not smooth, so holes are not corrected for that and "
        "their sigmas do not count it; <code>[vision] model = \"smooth\"</code> would.</p>\n",
        smooth_gain(*smooth, *best, "&#181;m"));
  }
  return out;
}

}  // namespace

std::string models_block(const SeriesResult& series) {
  if (series.compared.size() < 2) return {};
  const double least = least_criterion(series.compared);
  std::string out =
      "<details><summary>Models compared</summary>\n<div class=\"scroll\"><table class=\"grid\">"
      "<tr><th>model</th><th class=\"num\">parameters</th><th class=\"num\">chi square</th>"
      "<th class=\"num\" title=\"Akaike's: chi square + 2 parameters, from the least\">"
      "criterion</th><th class=\"num\">left-out rms, &#181;m</th><th></th></tr>\n";
  for (const ModelScore& score : series.compared) out += model_row(score, series, least);
  return out + "</table></div>\n</details>\n" + advice(series);
}

std::string model_line(const SeriesResult& series) {
  const ModelScore* best = chosen(series.compared);
  if (!series.chose_model || best == nullptr) return {};
  const ModelScore* other = nullptr;
  for (const ModelScore& score : series.compared) {
    if (!score.is_eligible || score.is_chosen) continue;
    if (other == nullptr || score.criterion < other->criterion) other = &score;
  }
  std::string out = fmt::format("  model \"{}\"", name(*best));
  if (other == nullptr) {
    out += ", the only one that the targets can check";
  } else {
    const double difference = other->criterion - best->criterion;
    out += fmt::format(", criterion {:.2f}; \"{}\" has {:.2f}, {}",
                       best->criterion,
                       name(*other),
                       other->criterion,
                       difference > 0 ? "which is worse" : "too little better to be softer for");
  }
  if (best->left_out_mm) {
    out += fmt::format("; left-out rms {:.2f} um", *best->left_out_mm * 1e3);
  }
  out += "\n";
  if (const ModelScore* smooth = recommended_smooth(series.compared)) {
    out += "  " + smooth_gain(*smooth, *best, "um") + "\n";
  }
  return out;
}

std::string nested_models_line(const Survey& survey) {
  std::map<PanelModel, int> count;
  int n = 0;
  for (const SeriesResult& series : survey.series) {
    if (!series.nested || !series.chose_model) continue;
    ++count[series.model];
    ++n;
  }
  if (n == 0) return {};
  std::string out = fmt::format("models of {}:", counted(n, "nested fit"));
  std::string_view separator = " ";
  for (const auto& [model, n_fits] : count) {
    out += fmt::format("{}{} {}", separator, n_fits, name(model));
    separator = ", ";
  }
  return out + "\n";
}

}  // namespace panelcal::report
