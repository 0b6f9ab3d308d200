// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/fit/search_area.h"
#include "vision/fit/target.h"
#include "vision/picture/image.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// A place where edges point to.
struct VotePeak {
  Eigen::Vector2d at_px;
  double votes = 0;  ///< relative to a whole rim; roughly 1 for a clean disc
};

/// Finds the middles of discs and rings of about one outer radius, all of them.
///
/// Each edge pixel votes for the places one radius away along its gradient, on the bright side for
/// bright targets. Works on the picture averaged down until the radius is 10 to 20 cells, so that
/// its cost hardly depends on the radius.
///
/// In     box: where to look at edges; edge_level: weakest contrast that counts, grey levels
/// Out    at most `max_peaks`, best first; precise to about a cell, radius / 10
/// Source Reisfeld, Wolfson and Yeshurun 1995; Loy and Zelinsky 2003
std::vector<VotePeak> radial_votes(const Image& image,
                                   const PixelBox& box,
                                   double radius_px,
                                   Polarity polarity,
                                   double edge_level,
                                   int max_peaks);

}  // namespace panelcal::internal
