// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "program/walk/execution/hole_sequence.h"
#include <Eigen/Core>
#include <tl/expected.hpp>

namespace panelcal::excellon {

/// The holes of a canned cycle, or a text with the problem and the remedy.
template <class T>
using Cycle = tl::expected<T, std::string>;

/// G82: two rows of holes between opposite corners.
///
/// The rows run through both corners, along the axis across which the corners are row_mm apart; if
/// that is so for none, along the longer side. The first row begins at corner_a, the second comes
/// back from corner_b.
///
/// In     pitch_mm: between the holes of a row; row_mm: between the rows; both > 0
///        rounding_mm: the resolution of the file's numbers
/// Fails  corners in one line; a square; corners that are row_mm apart neither in x nor in y, and
///        whose longer side comes as near to it; rows that are no whole number of pitches long
/// Source CNC-7 manual, Canned Cycle Commands, Dual In Line Package; semantics page, G82
/// See    tests/program/excellon/patterns/canned_cycles_test.cc
Cycle<HoleSequence> dual_in_line(const Eigen::Vector2d& corner_a_mm,
                                 const Eigen::Vector2d& corner_b_mm,
                                 double pitch_mm,
                                 double row_mm,
                                 double rounding_mm);

/// True if the corners of a G82 are row_mm apart in x or in y, as the rows should be.
bool has_row_spacing(const Eigen::Vector2d& corner_a_mm,
                     const Eigen::Vector2d& corner_b_mm,
                     double row_mm,
                     double rounding_mm);

/// G83: eight holes, 45 degrees apart, on the circle through two opposite ones, beginning at a.
///
/// Fails  the two holes in one place, or not on a horizontal or vertical line (within rounding_mm)
/// Source CNC-7 manual, Canned Cycle Commands, Eight Pin L Pack; semantics page, G83
/// See    tests/program/excellon/patterns/canned_cycles_test.cc
Cycle<HoleSequence> eight_pin(const Eigen::Vector2d& a_mm,
                              const Eigen::Vector2d& b_mm,
                              double rounding_mm);

/// G84: a big hole, drilled as a ring of overlapping ones from +x on.
///
/// The holes' centres lie on a circle of radius (D - d) / 2. There are just enough that the cusps
/// between neighbours stand less than 0.0005 inch out of the wall.
///
/// Fails  tool_diameter_mm not above zero; diameter_mm below two tool diameters
/// Source CNC-7 manual, Canned Cycle Commands, Canned Circle
/// See    tests/program/excellon/patterns/canned_cycles_test.cc
Cycle<HoleSequence> canned_circle(const Eigen::Vector2d& center_mm,
                                  double diameter_mm,
                                  double tool_diameter_mm);

/// G85: a slot, drilled in passes from start to end.
///
/// First adjacent holes: as many equal steps as fit without being shorter than the tool's diameter,
/// but one at least. Then the middles between the holes drilled so far, again and again, until the
/// cusps between neighbours are below 0.0005 inch. A slot of no length is one hole.
///
/// Fails  tool_diameter_mm not above zero
/// Source CNC-7 manual, Canned Cycle Commands, Slot
/// See    tests/program/excellon/patterns/canned_cycles_test.cc
Cycle<HoleSequence> canned_slot(const Eigen::Vector2d& start_mm,
                                const Eigen::Vector2d& end_mm,
                                double tool_diameter_mm);

/// The heights of the passes of a step slot above its final depth, the last one 0.
class StepDepths {
 public:
  StepDepths(double initial_mm, double increment_mm, std::int64_t n_passes)
      : initial_mm_(initial_mm), increment_mm_(increment_mm), n_passes_(n_passes) {}

  std::int64_t size() const { return n_passes_; }
  /// Precondition: 0 <= i < size().
  double operator[](std::int64_t i) const {
    return i == n_passes_ - 1 ? 0 : initial_mm_ + static_cast<double>(i) * increment_mm_;
  }

 private:
  double initial_mm_;
  double increment_mm_;
  std::int64_t n_passes_;
};

/// G87: from initial_mm down in steps of increment_mm, the last one reduced so that it ends at 0.
///
/// In     initial_mm: U, >= 0; increment_mm: Z, < 0
/// Fails  any other sign
/// Source CNC-7 manual, Canned Cycle Commands, Routed Step Slot Canned Cycle
/// See    tests/program/excellon/patterns/canned_cycles_test.cc
Cycle<StepDepths> step_slot_depths(double initial_mm, double increment_mm);

/// The way of the cutter's centre for a routed circle, whichever its sense.
///
/// plunge -> far -> near -> far are three arcs of radius_mm: 540 degrees in all, but for the little
/// that the plunge lies inside. Then a straight line from far to retract.
struct RoutedCircle {
  Eigen::Vector2d plunge_mm;   ///< 0.01 inch inside near
  Eigen::Vector2d near_mm;     ///< the circle's bottom
  Eigen::Vector2d far_mm;      ///< its top
  Eigen::Vector2d retract_mm;  ///< 0.1 inch inside far, or the centre if that comes first
  double radius_mm = 0;        ///< of the path: A less half the compensation
};

/// G32 and G33: an inside circle with plunge and retract points off its edge.
///
/// The manual's listing plunges at X#Y#, then has `G02X1Y1Ac`, `Y2`, `Y1` and `XrYr`, Ac being A
/// less half the compensation. Y1 and Y2 share their X, so they are the top and the bottom of the
/// circle; the text's 540 degrees end on the side opposite the plunge, so X1Y1 is the far edge, Y2
/// the edge beside the plunge and XrYr the retract point. Which of top and bottom comes first the
/// manual leaves open; here the plunge is at the bottom. The first arc has its ends 0.01 inch less
/// than a diameter apart and stays inside the circle, whichever its sense.
///
/// In     radius_mm: A; compensation_mm: the value of the compensation index, >= 0
/// Fails  radius_mm below half the compensation plus 0.01 inch
/// Source CNC-7 manual, Routing Commands, Routed Circle Canned Cycle CW or CCW
/// See    tests/program/excellon/patterns/canned_cycles_test.cc
Cycle<RoutedCircle> routed_circle(const Eigen::Vector2d& center_mm,
                                  double radius_mm,
                                  double compensation_mm);

}  // namespace panelcal::excellon
