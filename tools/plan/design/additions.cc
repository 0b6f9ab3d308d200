// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "calib/advice/added_targets.h"
#include "tools/plan/design/series.h"

namespace panelcal::plan {
namespace {

using Place = Position<frame::Nominal>;

/// If the model is not determined, this number of further targets is tried to make it so.
constexpr std::size_t kMostMissing = 4;

class AdditionSearch {
 public:
  AdditionSearch(const SeriesWork& work, const ModelRule& rule)
      : work_(work), rule_(rule), corners_(work.plan.places_hull) {
    for (const PlannedPlace& candidate : work.plan.candidates) places_.push_back(candidate.nominal);
  }

  /// Every candidate is a pad of which both coordinates are seen.
  PanelModel model_with(std::size_t n) const {
    std::vector<DesignTarget> design = work_.plan.design;
    design.resize(design.size() + n);
    return rule_(work_.plan.level, design);
  }

  Addition best(std::size_t n) const {
    return best_additions({.model = model_with(n),
                           .targets = work_.plan.design,
                           .candidates = places_,
                           .corners = corners_,
                           .base_cov = work_.plan.base_cov},
                          n);
  }

  AdditionPlan plan_of(const Addition& addition) const {
    AdditionPlan out{.is_best = addition.is_best};
    std::vector<DesignTarget> design = work_.plan.design;
    for (const std::size_t i : addition.chosen) {
      out.pads.push_back(work_.plan.candidates[i]);
      design.push_back({work_.plan.candidates[i].nominal});
    }
    out.model = rule_(work_.plan.level, design);
    out.fit = predict_fit(design, out.model, work_.plan.base_cov).fit;
    if (out.fit && work_.plan.predicts_errors) {
      out.latest = latest_error(work_.plan, design, *out.fit);
    }
    if (out.model != work_.plan.programmed) out.worst_if_kept = worst(design);
    return out;
  }

 private:
  /// Of all places, under the model in force; it is greatest at a corner of their hull.
  std::optional<double> worst(std::span<const DesignTarget> design) const {
    const auto fit = predict_fit(design, work_.plan.programmed, work_.plan.base_cov).fit;
    if (!fit) return std::nullopt;
    const LeverageMap leverage(fit->cov);
    double worst = 0;
    for (const Place& corner : corners_) worst = std::max(worst, leverage(corner));
    return worst;
  }

  const SeriesWork& work_;
  const ModelRule& rule_;
  std::vector<Place> places_;
  std::vector<Place> corners_;
};

}  // namespace

void find_additions(SeriesWork& work, const ModelRule& rule, std::size_t n_added) {
  SeriesPlan& plan = work.plan;
  const std::size_t most = rule.most_targets(plan.level);
  // If slots are measured (mode 5), so would the added ones be, and a pad is not one.
  plan.has_slots = std::ranges::any_of(
      plan.design, [](const DesignTarget& one) { return one.axes != ObservedAxes::Both; });
  if (!plan.has_slots) plan.n_addable = most - std::min(most, plan.design.size());
  if (plan.n_places == 0 || plan.n_addable == 0) return;
  const AdditionSearch search(work, rule);
  for (std::size_t k = 0; k <= std::min(kMostAdded, plan.n_addable); ++k) {
    plan.models_with.push_back(search.model_with(k));
  }
  const std::size_t n_missing = std::min(kMostMissing, plan.n_addable);
  std::size_t n = 1;
  Addition addition = search.best(n);
  while (!addition.worst_after && addition.chosen.size() == n && n < n_missing) {
    addition = search.best(++n);
  }
  if (!addition.chosen.empty()) plan.one = search.plan_of(addition);
  const std::size_t n_several = std::min(n_added, plan.n_addable);
  if (n_several <= n) return;
  addition = search.best(n_several);
  if (addition.chosen.size() > n) plan.several = search.plan_of(addition);
}

}  // namespace panelcal::plan
