// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "vision/fit/detection.h"
#include "vision/fit/frame.h"
#include "vision/fit/target.h"
#include <Eigen/Core>

// Not installed.
namespace panelcal::internal {

/// A place of the fit frame and its covariance in the picture.
PositionEstimate<frame::Image> in_image(const FitFrame& fit_frame,
                                        const Eigen::Vector2d& at,
                                        const Eigen::Matrix2d& cov);

/// Centre and size in the units of the outside world.
///
/// In     at, cov, size: in the fit frame's units
void set_place(const FitFrame& fit_frame,
               const Eigen::Vector2d& at,
               const Eigen::Matrix2d& cov,
               double size,
               TargetFit& fit);

/// The size of a fit over the one that is asked for; absent for a target without a size.
std::optional<double> size_ratio(const TargetFit& fit, const Target& target);

}  // namespace panelcal::internal
