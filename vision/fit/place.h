// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "vision/fit/detection.h"
#include "vision/fit/frame.h"
#include "vision/fit/target.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// Centre and size in the units of the outside world.
///
/// In     at, cov, size: in the fit frame's units
void set_place(const FitFrame& fit_frame,
               const Eigen::Vector2d& at,
               const Eigen::Matrix2d& cov,
               double size,
               TargetFit& fit);

/// Says by how much a length is off; empty if it is within the tolerance. Lengths in frame units.
std::optional<std::string> size_problem(
    const FitFrame& fit_frame, std::string_view what, double seen, double asked, double tolerance);

/// The size of a fit over the one that is asked for; absent for a target without a size.
std::optional<double> size_ratio(const TargetFit& fit, const Target& target);

}  // namespace panelcal::internal
