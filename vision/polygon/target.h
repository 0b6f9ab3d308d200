// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "vision/fit/detection.h"
#include "vision/fit/detector.h"
#include "vision/fit/frame.h"
#include "vision/fit/pattern_search.h"
#include "vision/polygon/fit.h"
#include <Eigen/Core>

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

/// Score, levels, noise, blur and what is visible.
void set_quality(const CellModel& model,
                 const CellFit& cell_fit,
                 const CellPlace& place,
                 TargetFit& fit);

/// The checks of a fitted cell target beside its looks.
struct CellJudgement {
  std::string_view border;           ///< name of its outline: "outline", "edges"
  std::optional<std::string> unfit;  ///< the objection to its size or place
  double turn_rad = 0;               ///< against the angle asked for
  double turn_sigma_rad = 0;
  double turn_tolerance_rad = 0;
  double max_sigma_px = 0;  ///< the blur that the fit was limited to
};

/// Sets the candidate's verdict and reason. Precondition: candidate.fit is filled.
void judge_cells(const DetectorInput& input,
                 const CellFit& cell_fit,
                 const CellJudgement& judgement,
                 FittedCandidate& candidate);

}  // namespace panelcal::internal
