// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>

#include "calib/panel/fit.h"
#include "calib/panel/smooth_panel.h"

namespace panelcal {

/// A series that healthy targets would give less often than this is rejected by its chi square.
inline constexpr double kMisfitChance = 1e-3;

namespace internal {
/// chi square per degree of freedom, less 1, where chi square rejects; else 0.
double misfit_excess(double chi_square, int degrees_of_freedom);
/// Adds `excess` times the covariance, but for what the choice of the model adds.
void count_misfit(double excess, RawSmooth& smooth);
}  // namespace internal

/// Lets the covariance of a fit grow by what its targets do not agree in.
///
///   r^2 = chi square / degrees of freedom      where p(chi square) < 0.001, else 1
///   cov(map) += (r^2 - 1) (cov(map) - cov(choice of the model))
///
/// A gate that would have refused such a series is wide or off. Its targets are then as uncertain
/// as they show, all by one factor, since it is unknown which of them is wrong. Targets that pass
/// keep the covariance that is stated: chance alone would make it smaller as often as larger.
///
/// Source Birge 1932, Phys. Rev. 40, 207; docs/formulation.md, The misfit
/// See    tests/calib/panel/misfit_test.cc
template <class To, class From>
void count_misfit(PanelFit<To, From>& fit) {
  const double excess = internal::misfit_excess(fit.chi_square, fit.degrees_of_freedom);
  if (excess == 0) return;
  fit.misfit_cov = excess * (fit.map.cov - fit.choice_cov);
  fit.map.cov += fit.misfit_cov;
  if (!fit.smooth) return;
  internal::RawSmooth smooth = fit.smooth->raw();
  internal::count_misfit(excess, smooth);
  fit.smooth = std::make_shared<const SmoothPanelFit<To, From>>(std::move(smooth));
}

}  // namespace panelcal
