// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace panelcal::internal {

/// A circle through the deviations of a rim's sectors.
struct RimCircle {
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  double grown_px = 0;    ///< of the radius
  std::vector<char> use;  ///< sectors that lie on it
  double seen = 0;  ///< part of the sectors that lie on it, the doubtful ones beside others too
  double arc = 0;   ///< equivalent_arc() of these
  double displaced = 0;  ///< longest arc that shows an edge elsewhere, part of the rim
  double scale_px = 0;   ///< sigma of these about it
  /// From the circle that left an arc out to this one through all of the rim.
  Eigen::Vector2d doubt_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d oval_px = Eigen::Vector2d::Zero();   ///< cos and sin of the second wave
  Eigen::Matrix2d unit_cov = Eigen::Matrix2d::Zero();  ///< of the shift for sectors of variance 1

  double used() const;  ///< part of the sectors
  Eigen::VectorXd residuals(const Eigen::VectorXd& deviations) const;
};

/// The deviations of all sectors from the least-squares circle of some.
Eigen::VectorXd residuals_about_circle(const Eigen::VectorXd& deviations,
                                       const std::vector<char>& use);

/// Least trimmed squares, started from the whole rim and from arcs of it, then least squares of the
/// sectors that lie within 3.5 sigmas. It withstands anything on less than 1 - `least_used` of the
/// rim, or of the sectors that show an edge where these are fewer than `least_used`; it needs half
/// of the rim, or `least_used` if that is less.
///
/// In     deviations: by sector, outwards, px; usable: sectors that show an edge at all;
///        n_smooth: neighbours that are judged together; floor_px: least sigma of a sector;
///        own_px: a rim whose sectors lie about one circle with a smaller sigma is taken whole if
///        the arc is not round itself and leaves more of it out; 0: never
/// Source Rousseeuw and Van Driessen 2006 (FAST-LTS)
RimCircle fit_rim_circle(const Eigen::VectorXd& deviations,
                         const std::vector<char>& usable,
                         int n_smooth,
                         double least_used,
                         double floor_px,
                         double own_px = 0);

}  // namespace panelcal::internal
