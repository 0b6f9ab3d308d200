// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/template/solver.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The residuals of a converged fit.
struct TemplateNoise {
  double all = 0;      ///< sigma of the residuals, grey levels
  double picture = 0;  ///< without what the template's own noise makes of it
};

/// In     white_noise: the picture's noise as its neighbouring pixels tell it
TemplateNoise template_noise(const TemplateProblem& problem,
                             const TemplateVector& p,
                             double white_noise);

/// Covariance of place, turn and log scale.
///
/// With the influence a_u = M^-1 J_smooth(u) / noise^2, M = sum J_smooth J_raw^T / noise^2 + prior:
///
///   cov = noise^2 sum_u a_u a_u^T + template_noise^2 sum_k b_k b_k^T,
///   b_k = sum_u gain(u) a_u d T(u) / d (template pixel k)
///
/// or, where the residuals are correlated (texture) and that gives more, sum_u,v a_u R(u - v) a_v^T
/// with their own autocovariance R.
///
/// Source White 1980 (sandwich); Newey and West 1987 (tapered autocovariance)
Eigen::Matrix4d template_covariance(const TemplateProblem& problem,
                                    const TemplateVector& p,
                                    const TemplateNoise& noise);

}  // namespace panelcal::internal
