// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/fit/frame.h"
#include "vision/picture/image.h"
#include "vision/template/equations.h"
#include "vision/template/model.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// A template as it was fitted to a picture.
struct TemplateFit {
  bool converged = false;
  TemplateVector parameters = TemplateVector::Zero();
  Eigen::Matrix4d cov = Eigen::Matrix4d::Zero();  ///< of place, turn and log scale
  double noise = 0;                               ///< sigma of the residuals, grey levels
  double picture_noise = 0;                       ///< the picture's own part
  double excluded = 0;                            ///< part of the pixels left out
  double clipped = 0;                             ///< part of the pixels at either end of the scale
  double seen_share = 0;   ///< part of the template that is inside the picture
  double correlation = 0;  ///< of model and picture, noise aside, 0 to 1
  double visible = 0;      ///< part of the template's structure that is where it should be
};

/// Registers a template by maximum likelihood, from coarse to fine.
///
///   I(u) = plane(u) + gain(u) T(pose(u)) + focus curvature(pose(u)) + noise
///
/// with place, turn, scale, plane, gain with its slopes and focus unknown and T a cubic B-spline.
/// Least squares find the pixels that do not belong (neighbours, debris, also faint ones by their
/// local means); the last steps then solve
///
///   sum_u J_smooth(u) (I(u) - model_raw(u)) / noise^2 = 0
///
/// in which the template's noise is not squared, see TemplateModel. The covariance counts the
/// picture's noise and the template's. The latter works like more noise in every picture, but is
/// the same in all of them: a mean of many pictures does not get rid of it.
///
/// In     start: place within about 2^level px, turn and scale within the same at the template's
///        rim; levels are not needed; gain_sign: -1 to look for the negative
/// Out    converged false if there is no such pattern
/// Cost   25 ms or less for a template of 92 x 84 px
/// Source Nocedal and Wright 2006, 10.3 (Levenberg and Marquardt); Fuller 1987, 2.4 (instruments)
/// See    tests/vision/template/fit_slow_test.cc
TemplateFit fit_template(const Image& image,
                         const FitFrame& fit_frame,
                         const TemplateModel& model,
                         const TemplateVector& start,
                         int level,
                         const TemplatePrior& prior,
                         double gain_sign);

}  // namespace panelcal::internal
