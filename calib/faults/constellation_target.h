// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace panelcal {

/// A place in a picture that may be the target, or something that stands where a target may.
struct ConstellationCandidate {
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();
  Eigen::Matrix2d cov_mm2 = Eigen::Matrix2d::Identity();
  double score = 1;    ///< 0 to 1, comparable within one picture
  bool counts = true;  ///< false: it may hide the target, but cannot be it
};

/// One target of a series and everything that its picture showed.
struct ConstellationTarget {
  Eigen::Vector2d expected_mm = Eigen::Vector2d::Zero();
  std::vector<ConstellationCandidate> candidates;
  /// Corners, in order, of the convex area in which every candidate is listed; absent: unknown, so
  /// that a place without a candidate says nothing.
  std::optional<std::array<Eigen::Vector2d, 4>> view_mm;
  /// The target lies within this distance of where it is expected; absent: anywhere in the view.
  std::optional<double> radius_mm;
};

}  // namespace panelcal
