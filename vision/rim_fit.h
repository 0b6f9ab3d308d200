// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "panelcal/vision/rim_model.h"

namespace panelcal::internal {

/// Sigma of a pixel's noise, which may differ on the target and around it; grey levels.
struct PixelNoise {
  double outside = 1;
  double inside = 1;
};

/// A window, the model that is fitted to it, and how its pixels count.
struct RimProblem {
  FitWindow window;
  RimModel model;
  double full_scale = 255;
};

/// Where a fit ended.
struct RimSolution {
  RimVector parameters = RimVector::Zero();
  RimMatrix information = RimMatrix::Zero();  ///< J^T W J of the fit's parameters, the rest 0
  double cost = 0;                            ///< weighted sum of squares
  int n_pixels = 0;
  bool converged = false;
};

/// Minimises sum w rho(level - I) by Levenberg-Marquardt with analytic gradients.
///
/// In     problem; start; huber: residuals beyond this many sigmas count
///        linearly, 0 for plain least squares; tolerance_px: stop at steps below. Excluded pixels
///        and pixels clipped at 0 or full scale where the model is beyond do not count.
/// Cost   about 15 ns a flat pixel and 60 ns a rim pixel per iteration; does not allocate
/// Source Nocedal and Wright 2006, 10.3; Huber 1964
RimSolution fit_rim(const RimProblem& problem,
                    const RimVector& start,
                    double huber,
                    double tolerance_px);

/// Sets the pixels' weights. They stay as they are while a fit runs, else it would not minimise.
void set_weights(RimProblem& problem, const RimVector& parameters, const PixelNoise& noise);

/// Sets is_excluded on pixels that do not belong to the picture of the target alone, and on their
/// surroundings. Returns how many are excluded, as part of all.
double exclude_strangers(RimProblem& problem, const RimVector& parameters);

/// Noise sigma on and around the target from the residuals of the pixels not excluded.
PixelNoise noise_of(const RimProblem& problem, const RimVector& parameters);

/// True if a clipped pixel tells nothing more: the model is beyond the scale's end as well.
inline bool is_clipped(double value, double level, double full_scale) {
  return (value >= full_scale && level >= full_scale) || (value <= 0 && level <= 0);
}

}  // namespace panelcal::internal
