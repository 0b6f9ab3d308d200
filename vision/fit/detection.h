// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/estimate.h"
#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include <Eigen/Core>

namespace panelcal {

enum class DetectionStatus {
  Found,
  NotFound,   ///< nothing in the searched area looks like the target
  Ambiguous,  ///< two or more candidates are equally good
  Rejected,   ///< a candidate, but not to be trusted: the reason says why
};

/// found, not_found, ambiguous, rejected: the words of measurement files.
std::string_view name(DetectionStatus status);

struct LocateOptions {
  /// Area in which the target's centre may be: a circle, or the whole picture if either is absent.
  std::optional<Position<frame::Image>> search_center;
  std::optional<PixelLength> search_radius;
  /// Candidates whose score is within this of the best one's are equally good. Larger is more
  /// careful: more pictures end as ambiguous, fewer as the wrong target.
  double ambiguity_margin = 0.15;
  /// Smallest difference of target and surroundings, relative to full scale. Below it, weave and
  /// stains begin to look like targets.
  double min_contrast = 0.06;
  /// Smallest score of a candidate; see TargetFit::score.
  double min_score = 0.65;
  /// Smallest visible arc of the rim; parts that are spread count as the arc that says as much.
  double min_visible = 0.7;
  /// Edges blurred by more, px, are out of focus.
  double max_blur_px = 6;
  /// Largest part of a rim's pixels at an end of the scale: clipped ones say little of an edge.
  double max_clipped = 0.6;
  /// Largest difference of a round target's diameters, relative: 0.01 is a camera tilted by 8
  /// degrees.
  double max_oval = 0.01;
  /// Largest deviation of a rim from round, rms, of the radius. It enters the covariance; more is
  /// another shape.
  double max_roughness = 0.08;
  /// Largest amplitude of a single wave of 4 to 8 periods around a rim, of the radius: regular
  /// hexagons have 0.036, octagons 0.02, squares 0.1.
  double max_lobes = 0.025;

  /// Fails  target-invalid: names the field, its value and the bound it breaks
  Expected<void> validate() const;
};

/// A target as it was fitted to the picture.
struct TargetFit {
  PositionEstimate<frame::Image> center;                           ///< px, px^2
  std::optional<PositionEstimate<frame::Optical>> center_optical;  ///< with a mapping; mm, mm^2
  PixelLength size;                                                ///< as Target::size means it
  std::optional<PixelLength> inner_size;                           ///< rings
  std::optional<Length> size_mm;                                   ///< with a mapping
  Angle angle;        ///< in the frame of Target; 0 for discs, holes and rings
  Angle angle_sigma;  ///< 0 where there is no angle
  /// 0 to 1: correlation of picture and fitted model over the target and its rim, camera noise
  /// aside, times the visible arc of the rim, as `min_visible` counts it.
  double score = 0;
  double blur_px = 0;     ///< sigma of the edge, the pixel's own width included
  double background = 0;  ///< level around the target at its centre, grey levels
  double contrast = 0;    ///< target minus background, grey levels; negative for dark ones
  double noise = 0;       ///< sigma of the residuals at the rim, grey levels
  double excluded = 0;    ///< part of the fitted window left out: neighbours, debris
  double visible = 1;     ///< part of the rim that is seen and looks like one
  double axis_ratio = 1;  ///< least over largest diameter of discs, holes and rings
  /// Rings: middle of the hole minus middle of the outer rim, px.
  Eigen::Vector2d hole_offset_px = Eigen::Vector2d::Zero();
  /// Slots: nothing was measured along this direction (in the frame), and the covariance there is
  /// that of the visible length.
  std::optional<Angle> blind_direction;
  std::optional<int> tag_id;
  /// Tags: in the order of the AprilTag library, counter-clockwise as seen from the front.
  std::vector<PositionEstimate<frame::Image>> corners;
  /// The fitted outlines as polygons, closed unless they leave the picture; px, for overlays.
  std::vector<std::vector<Eigen::Vector2d>> outlines_px;
};

/// One of the places that were looked at, for overlays and reports.
struct Candidate {
  Position<frame::Image> center;
  PixelLength size;
  double score = 0;
  std::string reason;  ///< of one that does not count; else empty
  std::vector<std::vector<Eigen::Vector2d>> outlines_px;           ///< as in TargetFit
  Eigen::Matrix2d cov_px2 = Eigen::Matrix2d::Zero();               ///< of `center`
  std::optional<PositionEstimate<frame::Optical>> center_optical;  ///< with a mapping; mm, mm^2
  std::optional<Length> size_mm;                                   ///< with a mapping
  bool counts = false;
};

/// The answer to "where is the target in this picture?".
struct Detection {
  DetectionStatus status = DetectionStatus::NotFound;
  std::string reason;             ///< empty if found
  std::optional<TargetFit> best;  ///< always if found; the best candidate if there was one
  int n_candidates = 0;           ///< number of `candidates` that count
  std::vector<Candidate> candidates;
  /// False: there were more places than are fitted, so that one without a candidate says nothing.
  bool lists_all = true;
  /// The size over the one that was asked for: of `best`, or of a mark that is the target but for
  /// its size.
  std::optional<double> size_ratio = {};
};

}  // namespace panelcal
