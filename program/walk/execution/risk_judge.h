// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "calib/correction/breaking_probability.h"
#include "calib/correction/unseen_shift.h"
#include "program/model/operation.h"
#include "program/walk/measuring/measuring.h"
#include "program/walk/options.h"

namespace panelcal {

/// Gives places the probability of breaking their tolerance, as far as it is known.
///
///   judged_risk   by the covariance: what [tolerance] is held against
///   risk          what outputs state: nothing where the machine's largest terms are not stated or
///                 the targets refuse the fit; at least kMinStatedRisk where an error that the
///                 targets do not show may break the tolerance
///
/// A risk below kMinStatedRisk is stated with a tolerance r only if
///
///   r >= u + k s   and   r >= k s',   k = sqrt(-2 ln kMinStatedRisk)
///
/// with u the largest shift by an unnoticed error of one target, s the place's larger sigma, s' the
/// same with the greatest noise that chi square does not exclude (calib/panel/reliability.h), and
/// never with fewer than kLeastSpareEquations.
///
/// All three grow convexly away from the targets: a bound at the corners of a cell holds inside.
///
/// See    tests/program/walk/walk_risk_test.cc; docs/formulation.md, What targets do not tell
class RiskJudge {
 public:
  RiskJudge(const WalkOptions& options, const CorrectionState& corrections);

  /// In     at: the place's nominal one, reference scaling done
  void judge(const Position<frame::Nominal>& at, Length radius, PlacedPoint& place);
  /// Of a hole where its own target was seen, which nothing checks.
  void judge_at_target(Length radius, PlacedPoint& place);

 private:
  struct Cell {
    std::int64_t index = 0;
    std::int64_t i_correction = 0;  ///< that its bounds belong to; 0: none
    double unseen_mm = 0;
    double least_radius_mm = 0;
  };
  void take_correction();
  const Cell& cell_at(const Position<frame::Nominal>& at);
  Cell bounds_at(const Eigen::Vector2d& corner_mm) const;

  const CorrectionState& corrections_;
  BreakingRisk breaking_risk_;
  bool states_machine_ = false;
  // Of the correction that is in force.
  const BaseFit* base_ = nullptr;
  const NestedFit* nested_ = nullptr;
  bool is_refused_ = false;
  bool can_be_stated_ = false;
  std::vector<UnseenShift> shifts_;
  TransformEstimate<frame::Actual, frame::Nominal> noisy_;
  std::int64_t i_correction_ = 0;  ///< counts them
  std::vector<Cell> cells_;        ///< as many as a panel has; places of others share a slot
  double furthest_mm_ = 0;         ///< by an unnoticed error, of all places so far
};

}  // namespace panelcal
