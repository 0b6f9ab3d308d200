// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "panelcal/vision/rim_fit.h"

namespace panelcal::internal {

/// Autocovariance of a fit's residuals in one part of the window, by lag in pixels.
struct Autocovariance {
  /// Lags up to this count; longer ones have too few pairs in a window to be estimated.
  static constexpr int kMaxLag = 40;

  double variance = 1;       ///< of all the residuals, grey levels squared
  double white = 1;          ///< what of it differs from pixel to pixel: camera noise
  bool is_textured = false;  ///< false: all of it is white
  std::vector<float> table;  ///< of the rest, (2 kMaxLag + 1)^2 values by rows, if textured

  double at(int dx, int dy) const {
    constexpr int kSide = 2 * kMaxLag + 1;
    return table[static_cast<std::size_t>((dy + kMaxLag) * kSide + dx + kMaxLag)];
  }
};

/// What is left after a fit: apart on the target and around it, since weave shows around it only.
struct ResidualCorrelation {
  Autocovariance outside;
  Autocovariance inside;
  double rim_noise = 0;   ///< sigma of the residuals at the rim, grey levels
  double rim_excess = 1;  ///< variance at the rim over what the parts predict, at least 1

  bool is_textured() const { return outside.is_textured || inside.is_textured; }
};

/// Estimates it from the residuals of a converged fit with weights.
///
/// Whether there is texture is told by a portmanteau test on short lags; if there is none the noise
/// counts as white. Rounding to whole levels is the least noise there is.
///
/// Cost   1 ms for a 130 px window of white noise, 4 ms if textured
/// Source Box and Pierce 1970 (test); Newey and West 1987 (tapered autocovariance)
ResidualCorrelation residual_correlation(const RimProblem& problem, const RimSolution& solution);

}  // namespace panelcal::internal
