// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "calib/panel/fit.h"
#include "calib/panel/gates.h"

namespace panelcal {

/// Fewer equations to spare than these tell neither an error of a target from the panel's own shape
/// nor the noise from chance.
inline constexpr int kLeastSpareEquations = 3;
/// Errors that the targets of a series would hide less often than this are excluded.
inline constexpr double kUnseenChance = 0.01;
/// An error above this is no target's: cameras do not search so far.
inline constexpr double kUnlimitedError_mm = 100;

/// The largest error of one target in one direction that would pass unnoticed.
struct UnseenError {
  std::size_t i_target = 0;  ///< in PanelFit::pairs
  Eigen::Vector2d error_mm = Eigen::Vector2d::Zero();
  /// No gate sees it, however large it is; then error_mm is kUnlimitedError_mm long.
  bool is_unlimited = false;
};

/// The errors that the targets of a series would not show of each other.
struct Reliability {
  /// In a fan of directions for each target.
  std::vector<UnseenError> unseen;
  /// The greatest noise that chi square does not exclude, as a ratio of variances to the stated
  /// one; at least 1; infinite with fewer than kLeastSpareEquations.
  double noise_ratio2 = 1;
  int degrees_of_freedom = 0;
  /// Bending takes up an error of a target: how much of it is not known.
  bool is_smooth = false;
  /// Chi square, a gate or the search for outliers refuses the fit, released or not.
  bool is_rejected = false;

  bool can_be_stated() const { return degrees_of_freedom >= kLeastSpareEquations && !is_smooth; }
};

namespace internal {
/// In     gain, linear: of the fit; mean_deviation_mm: as check_gates_raw
Reliability reliability_raw(std::span<const RawPair> pairs,
                            const Eigen::Matrix2d& linear,
                            const Eigen::Matrix<double, 6, Eigen::Dynamic>& gain,
                            double chi_square,
                            int degrees_of_freedom,
                            const GateLimits& limits);
}  // namespace internal

/// The errors that the gates in force and the targets' own agreement let pass.
///
/// An error u of target i changes residual j by R_ji u, R = I - J G, and chi square's noncentrality
/// by u' Q u, Q = C_i^-1 R_ii. It passes while
///
///   u' Q u <= lambda,   P(chi'^2(f, lambda) <= max(f, chi square seen)) = 0.01
///
/// and while residuals, rotation, stretch and offset stay inside their limits, to first order. An
/// error that the panel's own freedom takes up (Q u = 0) is limited by the gates alone. Likewise
/// noise r times as large as stated would give so small a chi square in 1 of 100 series:
///
///   r^2 = chi square seen / (value that chi square of f degrees of freedom exceeds by 0.99)
///
/// In     fit: of healthy targets or not; limits: [gates] in force
/// Cost   O(n^2)
/// Source Baarda 1968 (external reliability); Abdel-Aty 1954 (noncentral chi square)
/// See    tests/calib/panel/reliability_test.cc; docs/formulation.md, What targets do not tell
template <class To, class From>
Reliability reliability(const PanelFit<To, From>& fit, const GateLimits& limits) {
  const std::span<const TargetPair<To, From>> pairs(fit.pairs);
  Reliability out = internal::reliability_raw(internal::raw_pairs(pairs),
                                              fit.map.map.linear(),
                                              fit.gain,
                                              fit.chi_square,
                                              fit.degrees_of_freedom,
                                              limits);
  out.is_smooth = fit.smooth != nullptr;
  return out;
}

}  // namespace panelcal
