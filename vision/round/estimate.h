// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/fit/detection.h"
#include "vision/fit/frame.h"
#include "vision/picture/image.h"
#include "vision/round/model/model.h"
#include "vision/round/rays.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// A rim's fit and how well the picture agrees.
struct RimEstimate {
  bool converged = false;
  RimVector parameters = RimVector::Zero();
  Eigen::Matrix2d center_cov = Eigen::Matrix2d::Zero();  ///< fit frame units squared
  double correlation = 0;  ///< of picture and model over the target, camera noise aside
  double visible = 0;      ///< part of the rim that is seen
  double arc = 0;          ///< the arc that tells as much of the center, part of the rim
  double excluded = 0;     ///< part of the rim left out
  double clipped = 0;      ///< part of the band's pixels at an end of the scale
  double roughness = 0;    ///< deviation of the rim from round, beyond chance; of the radius, rms
  int n_lobes = 0;         ///< of a rim that is a wave around the circle, beyond chance
  double lobes = 0;        ///< their amplitude, of the radius
  double oval_sigma = 0;   ///< of the oval's components, by noise and roughness
  double rim_noise = 0;    ///< sigma of the residuals at the rim, grey levels
};

/// Fits a rim that was seen at `start`: by maximum likelihood where all is flat and the rim is
/// round, else sector by sector (rim_profile.h).
RimEstimate estimate_rim(const Image& image,
                         const FitFrame& fit_frame,
                         const ExpectedRim& expected,
                         const RimStart& start,
                         const LocateOptions& options);

}  // namespace panelcal::internal
