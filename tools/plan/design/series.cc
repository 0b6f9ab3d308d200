// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/design/series.h"

#include <algorithm>

namespace panelcal::plan {
namespace {

/// Outside of the hull begins a nanometre beyond it: copies are rounded.
constexpr double kOnHull_mm = 1e-6;
/// Of up to this number of targets kErrorTrials cases are drawn of one error.
constexpr std::size_t kFullyTried = 16;
/// Of more targets only the one is tried whose error is noticed latest.
constexpr std::size_t kMostTried = 8;
constexpr std::uint64_t kErrorSeed = 1;

void try_both_sizes(const SeriesPlan& plan,
                    std::span<const DesignTarget> design,
                    PanelModel model,
                    TargetError& error) {
  const int n_trials = error_trials(design.size());
  if (!error.noticed.from || n_trials == 0) return;
  const Eigen::Vector2d once = *error.noticed.from * error.noticed.direction;
  ErrorTrial trial{.targets = design,
                   .model = model,
                   .noise = plan.noise,
                   .limits = plan.limits,
                   .i_target = error.i_target,
                   .error = once};
  error.at_once = try_error(trial, n_trials, kErrorSeed);
  trial.error = 2 * once;
  error.at_twice = try_error(trial, n_trials, kErrorSeed);
}

}  // namespace

/// A case takes as long as the square of the number of targets.
int error_trials(std::size_t n_targets) {
  if (n_targets <= kFullyTried) return kErrorTrials;
  if (n_targets > kMostTriedTargets) return 0;
  const std::size_t work = kFullyTried * kFullyTried * static_cast<std::size_t>(kErrorTrials);
  return static_cast<int>(work / (n_targets * n_targets));
}

TargetError latest_error(const SeriesPlan& plan,
                         std::span<const DesignTarget> design,
                         const PredictedFit& fit) {
  const auto noticed = noticed_errors(design, fit, plan.noise, plan.limits);
  TargetError out;
  out.i_target = least_noticed(noticed);
  out.noticed = noticed[out.i_target];
  try_both_sizes(plan, design, fit.model, out);
  return out;
}

void SeriesWork::predict_models() {
  for (const PanelModel model : kPlannedModels) {
    const auto result = predict_fit(plan.design, model, plan.base_cov);
    ModelPlan one;
    one.model = model;
    one.is_programmed = model == plan.programmed;
    one.fit = result.fit;
    one.failure = result.failure;
    if (result.fit) {
      if (plan.predicts_errors) {
        const auto noticed = noticed_errors(plan.design, *result.fit, plan.noise, plan.limits);
        one.noticed = noticed[least_noticed(noticed)];
      }
      leverages.emplace_back(result.fit->cov);
      i_models.push_back(plan.models.size());
    }
    plan.models.push_back(std::move(one));
  }
}

void SeriesWork::predict_errors() {
  const auto& fit = plan.in_force().fit;
  if (!fit || !plan.predicts_errors) return;
  const auto noticed = noticed_errors(plan.design, *fit, plan.noise, plan.limits);
  const std::size_t latest = least_noticed(noticed);
  for (std::size_t i = 0; i < noticed.size(); ++i) {
    TargetError error{.i_target = i, .noticed = noticed[i]};
    if (noticed.size() <= kMostTried || i == latest) {
      try_both_sizes(plan, plan.design, plan.programmed, error);
    }
    plan.errors.push_back(error);
  }
}

void SeriesWork::see(const PassingPlace& place) {
  ++plan.n_places;
  for (std::size_t k = 0; k < leverages.size(); ++k) {
    plan.models[i_models[k]].stats.add(leverages[k](place.nominal), place);
  }
  corners.add(place.nominal);
  const Length outside = distance_outside(plan.hull, place.nominal);
  if (outside.in_mm() <= kOnHull_mm) return;
  ++plan.n_outside;
  if (outside <= plan.farthest) return;
  plan.farthest = outside;
  plan.farthest_place = place.kept();
}

}  // namespace panelcal::plan
