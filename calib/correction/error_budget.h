// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "calib/correction/stack.h"
#include <Eigen/Core>

namespace panelcal {

/// Group of holes that an error moves together.
enum class SharedBy : std::uint8_t {
  AllHoles,    ///< the same shift of every hole; no further target makes it smaller
  Camera,      ///< one error of all holes whose targets this camera saw; nor does it here
  Correction,  ///< holes under one correction move together, smoothly from place to place
  NoHole,      ///< drawn anew at every hole
};

/// "all holes", "holes of one camera", "holes of one fit", "this hole alone".
std::string_view name(SharedBy shared);

/// One source of error, with the covariance that it alone gives a hole.
struct BudgetTerm {
  std::string_view source;
  SharedBy shared = SharedBy::NoHole;
  Eigen::Matrix2d cov_mm2 = Eigen::Matrix2d::Zero();
  bool is_stated = false;  ///< in the machine's file, be it as zero

  bool counts() const { return is_stated || cov_mm2.trace() > 0; }
};

/// Sources of a hole's uncertainty. Sources are independent, so the covariances add up to the
/// hole's own. Sources that are zero are listed too: it is worth knowing what was left out.
using ErrorBudget = std::vector<BudgetTerm>;

Eigen::Matrix2d total_mm2(const ErrorBudget& budget);

/// One standard deviation in the direction in which it is largest.
Length largest_sigma(const Eigen::Matrix2d& cov_mm2);

/// Of a hole that is drilled through the corrections in force; empty without one.
///
/// In     nominal: what the corrections are applied to, reference scaling done
/// Out    terms whose sum is CorrectionStack::drilled at the place, but for rounding; of a panel
/// that
///        is bent one for what lies between the targets
/// Cost   O(targets)
/// See    tests/calib/correction/error_budget_test.cc
ErrorBudget error_budget(const CorrectionStack& stack, const Position<frame::Nominal>& nominal);

/// Of the whole map's coefficients: what the pictures alone make of them, and not knowing the
/// panel's model, and targets that do not agree. Those are the terms that a simulated job draws; it
/// has neither a stage nor a table.
///
/// Out    order and use as TransformEstimate's; zero without a correction
/// Cost   O(targets)
Eigen::Matrix<double, 6, 6> coefficients_cov_of_pictures(const CorrectionStack& stack);
/// The same of a place, for a smooth fit. Precondition: stack.smooth() is not null
Eigen::Matrix2d smooth_cov_of_pictures_mm2(const CorrectionStack& stack,
                                           const Position<frame::Nominal>& nominal);
/// Of a place on the panel, from the covariance of the coefficients.
Eigen::Matrix2d place_cov_mm2(const Eigen::Matrix<double, 6, 6>& coefficients_cov,
                              const Position<frame::Nominal>& nominal);

/// Of a hole that is drilled where its own target was seen (CNC-7 G38 and G48, SIEB & MEYER G36).
///
/// In     seen_mm2: the picture's covariance alone
ErrorBudget error_budget_at_target(const MachineUncertainty& machine,
                                   const Eigen::Matrix2d& seen_mm2,
                                   const CameraJacobian& by_camera,
                                   int i_camera);

}  // namespace panelcal
