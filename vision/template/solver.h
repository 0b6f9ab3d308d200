// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/template/equations.h"

namespace panelcal::internal {

/// The data of a fit's solvers.
struct TemplateProblem {
  const TemplateModel& model;
  TemplateWindow window;
  TemplatePrior prior;
  double full_scale = 255;
};

/// True if a pixel takes part: not excluded, and not clipped where the model is beyond as well.
bool takes_part(const TemplatePixel& pixel, double level, double full_scale);

/// Sets plane and gain, which are linear, to their best values at the pose of p.
void solve_levels(const TemplateProblem& problem, TemplateVector& p);

/// Minimises sum w rho(smooth model - I) by Levenberg-Marquardt.
///
/// In     p: the start; n: how many of the parameters are free; huber: residuals beyond this many
///        sigmas count linearly, 0 for plain least squares; tolerance_px: stop at smaller steps
/// Out    p; true if converged
bool minimise(
    const TemplateProblem& problem, int n, double huber, double tolerance_px, TemplateVector& p);

/// Solves sum J_smooth w (I - model_raw) = 0, from near by.
bool solve_with_smooth_rows(const TemplateProblem& problem, TemplateVector& p);

}  // namespace panelcal::internal
