// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/correction/stack.h"
#include "calib/panel/reliability.h"

namespace panelcal {

/// The effect of an unnoticed error of a target on the corrections in force.
struct UnseenShift {
  bool is_nested = false;                    ///< the target is of the nested fit
  const UnseenError* error = nullptr;        ///< of that fit's Reliability
  Eigen::Matrix<double, 6, 1> coefficients;  ///< its part in the whole map
};

/// Of all unnoticed errors of the targets of both fits; empty of a smooth base fit, for which they
/// are not known.
///
/// In     base, nested: of the fits of `stack`, which they outlive; null without one
/// See    tests/calib/correction/unseen_shift_test.cc
std::vector<UnseenShift> unseen_shifts(const CorrectionStack& stack,
                                       const Reliability* base,
                                       const Reliability* nested);

/// The one that moves a place furthest; null if there is none.
const UnseenShift* furthest(const std::vector<UnseenShift>& shifts,
                            const Position<frame::Nominal>& nominal);
Length shift_at(const UnseenShift& shift, const Position<frame::Nominal>& nominal);

/// The part of the greatest noise that the targets do not exclude in the whole map's covariance.
///
/// Precondition: stack.smooth() is null; both ratios are finite
Eigen::Matrix<double, 6, 6> unseen_noise_cov(const CorrectionStack& stack,
                                             const Reliability* base,
                                             const Reliability* nested);

}  // namespace panelcal
