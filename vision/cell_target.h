// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "panelcal/vision/cell_fit.h"
#include "panelcal/vision/fit_frame.h"
#include "panelcal/vision/locate.h"
#include "panelcal/vision/pattern_search.h"

namespace panelcal::internal {

/// A model as a reduced picture shows it: its share.
///
/// In     half: half of the side of what is drawn, frame units; frame_from_px: jacobian of the fit
///        frame, which is taken as the same everywhere
SearchPattern drawn(const CellModel& model,
                    const CellState& state,
                    double half,
                    const Eigen::Matrix2d& frame_from_px,
                    int factor);

/// A quick fit to a reduced picture from where the search saw the model; its sigma is that of the
/// full picture. Empty if there is no such thing.
///
/// In     reach: how far around the model pixels are used, frame units
std::optional<CellState> rough_fit(const ReducedPicture& reduced,
                                   const FitFrame& fit_frame,
                                   const CellModel& model,
                                   const CellState& start,
                                   double reach);

/// Centre and size in the units of the outside world. In     size: frame units
void set_place(const FitFrame& fit_frame, const CellPlace& place, double size, TargetFit& fit);

/// Score, levels, noise, blur and what is visible.
void set_quality(const CellModel& model,
                 const CellFit& cell_fit,
                 const CellPlace& place,
                 TargetFit& fit);

/// Says by how much a length is off; empty if it is within the tolerance. Lengths in frame units.
std::optional<std::string> size_problem(
    const FitFrame& fit_frame, std::string_view what, double seen, double asked, double tolerance);

}  // namespace panelcal::internal
