// SPDX-License-Identifier: Apache-2.0
#include "tools/run/model_lines.h"

#include <algorithm>
#include <map>

#include "calib/base/number_text.h"
#include "calib/panel/model_choice.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// "a smooth model would predict left-out targets to 8.10 um instead of 17.30 um"
std::string smooth_gain(const ModelScore& smooth, const ModelScore& best) {
  return fmt::format("a smooth model would predict left-out targets to {} um instead of {} um",
                     internal::fixed(*smooth.left_out_mm * 1e3, 2),
                     internal::fixed(*best.left_out_mm * 1e3, 2));
}

}  // namespace

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
    out += "  " + smooth_gain(*smooth, *best) + "\n";
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
  std::string out = fmt::format("models of {}:", internal::counted(n, "nested fit"));
  std::string_view separator = " ";
  for (const auto& [model, n_fits] : count) {
    out += fmt::format("{}{} {}", separator, n_fits, name(model));
    separator = ", ";
  }
  return out + "\n";
}

}  // namespace panelcal
