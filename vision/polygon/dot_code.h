// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace panelcal::internal {

/// A dot that was seen; mm if there is a camera mapping, else px.
struct SeenDot {
  Eigen::Vector2d at;
  Eigen::Matrix2d cov;
};

/// Of a dot's diameter: dots do not overlap, so within half of one nothing else can be.
inline constexpr double kDotPlaceTolerance = 0.45;

/// A dot-code to look for, in the same units.
struct DotCode {
  std::span<const Eigen::Vector2d> dots;  ///< from the code's place
  double turn = 0;                        ///< rad
  double turn_tolerance = 0;
  double scale_tolerance = 0;  ///< relative
  /// A dot this far from where the code has it still is that dot.
  double place_tolerance = 0;
  bool fits_scale = false;  ///< the scale is unknown: there is no camera mapping
};

/// Number of a code's dots that have to be seen: all of up to three, else three quarters.
int least_dots(int n_dots);

/// Index of the seen dot of each dot of the code; empty if none is seen.
using DotAssignment = std::vector<std::optional<int>>;

/// Finds every way in which enough of a code's dots are among those seen.
///
/// Pairs of dots are hypotheses of place, turn and scale. As many pairs without a common dot are
/// tried as dots may be missing, and one more, so that one of them is whole. A way that shares a
/// dot with one of more dots is left out.
///
/// Cost   O(seen^2) for each such pair to compare lengths and angles; the few that fit cost O(dots)
/// Source Wolfson and Rigoutsos 1997 (geometric hashing)
/// See    tests/vision/polygon/dots_detector_test.cc
std::vector<DotAssignment> match_dots(const DotCode& code, std::span<const SeenDot> seen);

/// Place of a code.
struct DotPose {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  double turn = 0;
  double log_scale = 0;
  Eigen::Matrix4d cov =
      Eigen::Matrix4d::Zero();  ///< of at, turn, log_scale (0 if it was not fitted)
  double chi_square = 0;        ///< of the residuals
  int degrees_of_freedom = 0;
  double worst = 0;  ///< largest residual, and whose
  int worst_dot = 0;
};

/// Fits place and turn (and scale) by generalised least squares.
///
///   seen_i = at + e^log_scale R(turn) dot_i + e_i,   e_i ~ N(0, cov_i)
///
/// Precondition: at least two dots are assigned.
DotPose fit_dots(const DotCode& code,
                 std::span<const SeenDot> seen,
                 const DotAssignment& assignment);

/// By which angle a code may be turned within its tolerance so that it looks the same: its
/// orientation is unknown then.
std::optional<double> self_turn(const DotCode& code);

}  // namespace panelcal::internal
