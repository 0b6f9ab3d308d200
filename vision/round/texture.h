// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "vision/round/fit.h"
#include "vision/round/residuals.h"
#include "vision/round/window.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// A rim fitted on textured ground.
struct TexturedRim {
  RimVector parameters = RimVector::Zero();
  Eigen::Matrix2d center_cov = Eigen::Matrix2d::Zero();  ///< fit frame units squared
};

/// Goes from a plain fit to the best one that takes the ground's texture for what it is.
///
/// In     window: collected about the solution with stride 1; residuals and noise of it
/// Out    empty if what is around the target has no texture after all, or if no step leads to a fit
/// See    texture_fit.h
std::optional<TexturedRim> fit_on_texture(const RimWindow& window,
                                          const RimSolution& plain,
                                          const RimResiduals& residuals,
                                          const RimNoiseEstimate& noise);

}  // namespace panelcal::internal
