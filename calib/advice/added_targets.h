// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "calib/advice/target_design.h"

namespace panelcal {

/// Which places might be measured too, and for whose sake.
struct AdditionProblem {
  PanelModel model = PanelModel::Stretch;
  std::span<const DesignTarget> targets;                 ///< those that are measured anyway
  std::span<const Position<frame::Nominal>> candidates;  ///< each may be taken once
  std::span<const Position<frame::Nominal>> corners;     ///< of the hull of the holes
  MapCovariance base_cov = MapCovariance::Zero();        ///< see predict_fit
};

/// The further targets that make the greatest leverage of all holes least.
struct Addition {
  std::vector<std::size_t> chosen;     ///< indices into candidates, ascending
  std::optional<double> worst_before;  ///< absent: the targets do not determine the model
  std::optional<double> worst_after;
  /// All choices were tried; else it is the best of those that a search came upon.
  bool is_best = false;
};

/// Chooses `n_added` of the candidates.
///
/// One is found by trying all. Several are found by single exchanges (Fedorov 1972), first for the
/// 12th power mean over the corners, which does not stall where several holes are equally bad, then
/// for the worst one; begun with what is best one after the other, and with 12 choices by chance
/// (always the same ones), then, up to 6, by exchanges of two for all pairs of some 150 candidates.
/// So two of up to 150 candidates are the best pair; more are no proof of the optimum. Only the
/// corners count, since the leverage is convex. With many targets the choice tends to the
/// continuous D-optimal design, which is G-optimal as well (Kiefer and Wolfowitz 1960).
///
/// Fails  worst_after stays absent if not even the candidates determine the model; fewer are chosen
///        if there are not enough candidates
/// Cost   O(n_added candidates corners) for each pass of exchanges; some 3 us for each of them
/// See    tests/calib/advice/added_targets_test.cc
Addition best_additions(const AdditionProblem& problem, std::size_t n_added);

}  // namespace panelcal
