// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "program/geometry/arcs.h"
#include <Eigen/Core>
#include <tl/expected.hpp>

namespace panelcal::sieb_meyer {

/// The way of the cutter's centre for a finished figure. Programmed coordinates, mm.
///
/// The pieces begin at plunge_mm and chain exactly; arcs are at most half circles.
struct FigurePath {
  Eigen::Vector2d plunge_mm = Eigen::Vector2d::Zero();
  std::vector<Arc> pieces;
};

enum class Turn : std::uint8_t { Counterclockwise, Clockwise };

enum class Cut : std::uint8_t {
  Contour,
  Area,  ///< G43: also what lies inside
};

/// G45 and G46: a round hole, the cutter inside.
///
/// The path is a circle of radius r - FD / 2, from its top all round. The cutter comes to the top
/// on an eighth of the circle of half that radius that touches the path there, and leaves on the
/// mirrored eighth. The plunge point is the eighth's other end: with k = r / 2 - FD / 4
///   c + k (sqrt(1/2), 1 + sqrt(1/2))    counterclockwise; clockwise mirrored in x.
/// Cut::Area: from the plunge point first to the top of the innermost of evenly spaced rings, and
/// ring by ring outwards, each from its top all round in the same turn; then back to the plunge
/// point and on as above. The innermost ring has a radius of at most 0.35 FD and neighbours are at
/// most 0.7 FD apart.
///
/// In     radius_mm: of the hole, > 0; cutter_diameter_mm: FD, > 0
/// Fails  other signs; a cutter that does not fit in; more than 10000 rings
/// Source SIEB & MEYER manual, G45, G46, G43
/// See    tests/program/sieb_meyer/figures/rout_figures_test.cc
tl::expected<FigurePath, std::string> circle_inside(const Eigen::Vector2d& center_mm,
                                                    double radius_mm,
                                                    double cutter_diameter_mm,
                                                    Turn turn,
                                                    Cut cut = Cut::Contour);

/// G47 and G48: a disk, the cutter outside.
///
/// The path is a circle of radius r + FD / 2, from its leftmost point all round. The cutter comes
/// there straight along the tangent, from FD / 2 away, and goes on as far behind it.
///
/// In     radius_mm: of the disk, > 0; cutter_diameter_mm: FD, > 0
/// Fails  other signs
/// Source SIEB & MEYER manual, G47, G48
/// See    tests/program/sieb_meyer/figures/rout_figures_test.cc
tl::expected<FigurePath, std::string> disk_outside(const Eigen::Vector2d& center_mm,
                                                   double radius_mm,
                                                   double cutter_diameter_mm,
                                                   Turn turn);

/// G49 and G50: a rectangular hole, the cutter inside.
///
/// From the plunge point, j / 4 - FD / 4 above the centre, straight to the middle of the path's top
/// side, all round, back to that middle and to the plunge point. Cut::Area: instead of straight to
/// the top side, first round the innermost of evenly spaced rectangles, and on outwards, each from
/// the middle of its top side in the same turn. The innermost one's shorter sides are at most
/// 0.7 FD, and neighbours are at most 0.7 FD apart.
///
/// In     sides_mm: of the hole along x and y, > 0; cutter_diameter_mm: FD, > 0
/// Fails  other signs; a cutter that does not fit in; more than 10000 rings
/// Source SIEB & MEYER manual, G49, G50, G43
/// See    tests/program/sieb_meyer/figures/rout_figures_test.cc
tl::expected<FigurePath, std::string> rectangle_inside(const Eigen::Vector2d& center_mm,
                                                       const Eigen::Vector2d& sides_mm,
                                                       double cutter_diameter_mm,
                                                       Turn turn,
                                                       Cut cut = Cut::Contour);

}  // namespace panelcal::sieb_meyer
