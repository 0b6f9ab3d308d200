// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "calib/advice/target_design.h"

namespace panelcal {

/// The greatest leverage of all holes in nine of ten jobs, for a job that chooses its model by what
/// it measures ([vision] model = "auto").
struct ChosenRange {
  double low = 0;
  double high = 0;
};

/// Targets, the model that the manual has for them, and for whose sake they are measured.
struct ChoiceProblem {
  std::span<const DesignTarget> targets;
  PanelModel usual = PanelModel::Stretch;
  MapCovariance base_cov = MapCovariance::Zero();     ///< see predict_fit
  std::span<const Position<frame::Nominal>> corners;  ///< of the hull of the holes
};

/// Measures panels of every kind with the noise of the targets, lets compare_models choose, and
/// takes the covariance that fit_chosen would state, with what it adds for the choice.
///
/// The panels: one for each model, whose deformations are far above the noise, and one for each in
/// which the softest of them is as large as three times the noise, where the choice is in doubt.
/// The range reaches from the least 5 % of any kind to the greatest 95 %. A panel that is bent
/// smoothly is not among them.
///
/// Out    absent where not even an offset is determined; the same on every machine
/// Cost   some 900 comparisons of models
/// See    tests/calib/advice/chosen_range_test.cc
std::optional<ChosenRange> chosen_range(const ChoiceProblem& problem);

}  // namespace panelcal
