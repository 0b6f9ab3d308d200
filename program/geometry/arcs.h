// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace panelcal {

/// A piece of a circle, at most half of it. All coordinates in one frame, x right, y up.
struct Arc {
  Eigen::Vector2d start_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d end_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d center_mm = Eigen::Vector2d::Zero();  ///< equally far from both ends
  bool clockwise = false;
  bool straight = false;  ///< a line within 1e-9 mm; center_mm is then only the chord's middle
};

enum class ArcFault : std::uint8_t {
  None,
  NoChord,         ///< start and end are the same point
  RadiusMismatch,  ///< no circle, or none of at most half a turn, has these numbers
};

/// An arc made of a program's numbers.
///
/// With NoChord the arc's centre is start_mm. With RadiusMismatch from I and J the arc has the
/// centre as programmed (the better of the two readings), and adjusted_mm is the difference of its
/// radii: small if the only thing wrong is that the arc would be more than half a circle.
struct ArcFit {
  Arc arc;
  ArcFault fault = ArcFault::None;
  double adjusted_mm = 0;  ///< change of the radius; 0 if rounding explains it
};

/// The arc of a radius (`A#`) through two points.
///
/// The centre lies right of the chord for a clockwise arc, left of it for a counterclockwise one.
/// A radius below half the chord becomes half the chord, as the machine adjusts it.
///
/// In     rounding_mm: the resolution of the file's numbers, >= 0
/// Fails  NoChord: ends closer than rounding_mm; RadiusMismatch: radius negative or not finite
/// Source CNC-7 manual, Routing Commands: Circular Clockwise Move, Arc Radius
/// See    tests/program/geometry/arcs_test.cc
ArcFit arc_from_radius(const Eigen::Vector2d& start_mm,
                       const Eigen::Vector2d& end_mm,
                       double radius_mm,
                       bool clockwise,
                       double rounding_mm);

/// The arc of a centre offset (`I#J#`) through two points.
///
/// I and J may be start - centre (the manual) or centre - start (CAM systems): as an arc is at most
/// half a circle, only one of them is equally far from both ends and on the right side of the
/// chord. On a tie the manual's sign holds. A centre whose two radii differ by up to 3 %, or by no
/// more than rounding explains (3 steps), is moved onto the chord's perpendicular bisector.
///
/// In     rounding_mm: the resolution of the file's numbers, >= 0
/// Fails  NoChord: ends closer than rounding_mm
///        RadiusMismatch: radii that differ by more, or change by more than 3 % when adjusted;
///        more than half a circle (beyond rounding); numbers that are not finite
/// Source CNC-7 manual, Routing Commands: Arc Center Offset; semantics page, I/J
/// See    tests/program/geometry/arcs_test.cc
ArcFit arc_from_center_offset(const Eigen::Vector2d& start_mm,
                              const Eigen::Vector2d& end_mm,
                              const Eigen::Vector2d& ij_mm,
                              bool clockwise,
                              double rounding_mm);

/// The image of an arc under `x -> linear * x + translation`, as arcs.
///
/// A similarity gives one arc; a mirror flips the sense. Any other map makes an ellipse, which is
/// halved (by the parameter of the original arc) until the circle through start, middle and end of
/// each piece is within tolerance_mm of it everywhere, by a bound and not by sampling. Where that
/// circle would make more than half a turn, half a circle over the chord stands in for it.
///
/// In     arc: start_mm != end_mm
/// Out    1 to 4096 arcs; they begin and end exactly at the mapped ends and chain exactly. Pieces
///        flatter than 1e-9 mm are straight. At 4096 pieces splitting ends whatever the tolerance:
///        that is some 1e-8 mm for an arc of a metre.
/// Fails  never. A singular map gives straight pieces (there and back if need be), a map or an arc
///        that is not finite or has no chord gives one straight piece between the mapped ends.
/// Cost   O(pieces)
/// Source CNC-7 manual, Multipoint Vision Translation (stretch); semantics page, `arc_tolerance_um`
/// See    tests/program/geometry/arcs_test.cc
std::vector<Arc> carry_arc(const Arc& arc,
                           const Eigen::Matrix2d& linear,
                           const Eigen::Vector2d& translation_mm,
                           double tolerance_mm);

}  // namespace panelcal
