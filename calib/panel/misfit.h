// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>

#include "calib/panel/fit.h"
#include "calib/panel/smooth_panel.h"

namespace panelcal {

/// A series that healthy targets would give less often than this is rejected by its chi square,
/// where [gates] false_alarm says nothing else.
inline constexpr double kMisfitChance = 1e-3;
/// With this many equations to spare the scatter is an estimate of the noise, and counts where
/// healthy targets would scatter so much less often than kScatterChance.
inline constexpr int kScatterEquations = 3;
inline constexpr double kScatterChance = 0.1;

namespace internal {
/// The ratio of variances by which the stated noise is too small, as chi square shows, less 1; 0
/// where it does not.
double misfit_excess(double chi_square, int degrees_of_freedom);
/// Adds `excess` times the covariance, but for what the choice of the model adds.
void count_misfit(double excess, RawSmooth& smooth);
}  // namespace internal

/// Lets the covariance of a fit grow by what its targets do not agree in.
///
///   r^2 = c chi square / f      where P(chi square, f) < 0.1 (f < 3: < 0.001), else 1
///   c   = f (0.05^(-2 / f) - 1) / 5.991      (f < 3: 1)
///   cov(map) += (r^2 - 1) (cov(map) - cov(choice of the model))
///
/// The targets are then as uncertain as they show (Birge), all by one factor, since it is unknown
/// which of them is wrong. c makes the 95 % ellipse that of Hotelling's T^2, since the noise is
/// estimated from f equations. Fewer than 3 of them estimate none: there the ratio waits until chi
/// square rejects. Healthy targets grow in one series of 10, so their ellipses hold at most 95.5 %.
///
/// Source Birge 1932, Phys. Rev. 40, 207; Hotelling 1931; docs/formulation.md, The misfit
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
