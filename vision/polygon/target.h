// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "vision/fit/detection.h"
#include "vision/fit/detector.h"
#include "vision/fit/frame.h"
#include "vision/fit/pattern_search.h"
#include "vision/polygon/fit.h"
#include <Eigen/Core>

// Not installed. What squares, crosses and slots share.
namespace panelcal::internal {

/// Guide of the search for a target made of cells; lengths in frame units.
struct CellSearch {
  double size = 0;      ///< of the target, or of its narrower side
  double seen_px = 16;  ///< the search sees that size about this number of pixels wide
  double reach_px = 0;  ///< of what is searched about a place
  /// Half of the side of what is drawn, over the size, at an angle.
  double (*half_of_size)(double angle_rad) = nullptr;
  double angle_rad = 0;  ///< of the pattern
  double angle_tolerance_rad = 0;
  std::size_t max_peaks = kMaxFitted;

  /// Of the picture that is searched.
  int factor() const;
};

/// A reduced picture and where it shows a target, best first: a pixel, and a state about it.
struct CellSightings {
  struct Peak {
    Eigen::Vector2d at_px;
    CellState state;
  };
  ReducedPicture reduced;
  std::vector<Peak> peaks;
};

/// In     model: as it is drawn
CellSightings search_cells(const DetectorInput& input,
                           const CellSearch& search,
                           const CellModel& model);

/// A quick fit to a reduced picture from where the search saw the model; its sigma is that of the
/// full picture. Empty if there is no such thing.
///
/// In     reach: how far around the model pixels are used, frame units
std::optional<CellState> rough_fit(const ReducedPicture& reduced,
                                   const FitFrame& fit_frame,
                                   const CellModel& model,
                                   const CellState& start,
                                   double reach);

/// Place, size and angle, score, levels, noise, blur and what is visible.
void fill_target(const FitFrame& fit_frame,
                 const CellModel& model,
                 const CellFit& cell_fit,
                 const CellPlace& place,
                 double size,
                 double angle_rad,
                 TargetFit& fit);

/// The demands on a fitted target of cells beside its looks.
struct CellJudgement {
  std::string_view border;  ///< name of its outline: "outline", "edges"
  Problem unfit;            ///< the objection to its size or place
  double turn_rad = 0;      ///< against the angle asked for
  double turn_tolerance_rad = 0;
  double max_sigma_px = 0;  ///< the blur that the fit was limited to
};

Judgement judge_cells(const DetectorInput& input,
                      const CellFit& cell_fit,
                      const TargetFit& fit,
                      const CellJudgement& judgement);

}  // namespace panelcal::internal
