// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "vision/fit/detection.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The subject of a line of the legend or of a drawn line.
enum class Ink { Plain, Quiet, Good, Bad, Other };

struct LegendLine {
  std::string text;
  Ink ink = Ink::Plain;
};

/// The text of an overlay.
struct Legend {
  std::vector<LegendLine> verdict;     ///< title, status, reason
  std::vector<LegendLine> facts;       ///< about the best candidate; empty if there is none
  std::vector<LegendLine> candidates;  ///< the others, by number, and why they do not count
};

Legend legend_of(const Detection& detection, std::string_view title);

/// The colour of what is drawn for the best candidate.
inline Ink ink_of(DetectionStatus status) {
  return status == DetectionStatus::Found ? Ink::Good : Ink::Bad;
}

/// The ellipse that holds a place with the probability 0.95, as semi-axes.
struct UncertaintyEllipse {
  Eigen::Vector2d major_px;  ///< direction and length
  Eigen::Vector2d minor_px;
};
/// In     cov_px2: symmetric, positive definite
UncertaintyEllipse uncertainty_ellipse(const Eigen::Matrix2d& cov_px2);

/// The largest 1, 2 or 5 times a power of ten that is not above v. Precondition: v > 0, finite.
double round_length(double v);

}  // namespace panelcal::internal
