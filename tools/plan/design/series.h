// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "calib/advice/convex_hull.h"
#include "tools/plan/design/plan.h"

namespace panelcal::plan {

/// One series while its plan is made.
struct SeriesWork {
  SeriesPlan plan;
  std::vector<LeverageMap> leverages;  ///< of the models that are determined
  std::vector<std::size_t> i_models;   ///< their indices
  HullBuilder corners;
  std::optional<CandidatePool> pool;

  /// The series' design under each model. Precondition: plan.design, plan.base_cov
  /// and plan.programmed are there.
  void predict_models();
  /// The answers of a job to an error of each target, under the model in force. Precondition:
  /// plan.limits.
  void predict_errors();
  /// Takes a place that this series corrects.
  void see(const PassingPlace& place);
};

/// Cases that are drawn of one error, so that a share of a half is known to 3.5 %.
inline constexpr int kErrorTrials = 200;
/// Of more targets no error is tried: fewer than 20 cases would tell nothing.
inline constexpr std::size_t kMostTriedTargets = 50;

/// Cases that are drawn of one error of a series of this many targets: kErrorTrials of few, fewer
/// of many, so that the work is the same, and 0 above kMostTriedTargets.
int error_trials(std::size_t n_targets);

/// Of the target whose error is noticed latest. Precondition: the design is not empty.
TargetError latest_error(const SeriesPlan& plan,
                         std::span<const DesignTarget> design,
                         const PredictedFit& fit);

/// Finds the best single pad (or the fewest that determine the model) and the best `n_added`; the
/// model is always the one that a job would fit to that many targets.
void find_additions(SeriesWork& work, const ModelRule& rule, std::size_t n_added);

}  // namespace panelcal::plan
