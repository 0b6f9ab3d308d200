// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "program/walk/execution/hole_sequence.h"
#include <Eigen/Core>
#include <tl/expected.hpp>

namespace panelcal::sieb_meyer {

/// V1: two parallel rows of holes between opposite corners. A falling diagonal has rows along x, a
/// rising one along y; other axis versions place them afterwards.
///
/// The first row begins at first_mm, the second comes back from the diagonal corner. Without W the
/// pitch is 2.54 mm, and both the rows' length and their distance become whole numbers of pitches,
/// counted from first_mm. With W the rows keep their length, the pitch is length / (W - 1), and
/// their distance becomes a whole number of these.
///
/// In     n_in_row: W, >= 2
/// Fails  corners in one line; a length or distance below half a pitch, or half way between two
///        whole numbers of pitches
/// Source SIEB & MEYER manual, V1; semantics page, V1
/// See    tests/program/sieb_meyer/figures/drill_patterns_test.cc
tl::expected<HoleSequence, std::string> dual_row(const Eigen::Vector2d& first_mm,
                                                 const Eigen::Vector2d& second_mm,
                                                 std::optional<std::int64_t> n_in_row);

/// V2: a row of evenly spaced holes, the first and the last one included, at any angle.
///
/// In     n_holes: W, >= 2; 1 if both points are the same
/// Fails  any other W; several holes in one place
/// Source SIEB & MEYER manual, V2
/// See    tests/program/sieb_meyer/figures/drill_patterns_test.cc
tl::expected<HoleSequence, std::string> single_row(const Eigen::Vector2d& first_mm,
                                                   const Eigen::Vector2d& last_mm,
                                                   std::int64_t n_holes);

/// V3: holes on all four sides of a rectangle, once each.
///
/// Pitch and corners are those of `dual_row`. From first_mm the holes go along the side that would
/// be V1's first row, and on round the rectangle. The manual's last example, sides of 10 and 40 mm
/// with W9, has a pitch of 5 mm by its own rule, not the 2.5 mm of its text (they are W17).
///
/// In     n_in_row: W, >= 2: of the side along which V1's rows would run
/// Fails  as `dual_row`
/// Source SIEB & MEYER manual, V3; semantics page, V3
/// See    tests/program/sieb_meyer/figures/drill_patterns_test.cc
tl::expected<HoleSequence, std::string> quadruple_row(const Eigen::Vector2d& first_mm,
                                                      const Eigen::Vector2d& second_mm,
                                                      std::optional<std::int64_t> n_in_row);

/// V4: holes evenly spaced all round a circle, counterclockwise from first_mm on.
///
/// In     first_mm: any hole on the circle; n_holes: W, >= 1
/// Fails  no holes; first_mm in the centre
/// Source SIEB & MEYER manual, V4; semantics page, V4
/// See    tests/program/sieb_meyer/figures/drill_patterns_test.cc
tl::expected<HoleSequence, std::string> circular_row(const Eigen::Vector2d& center_mm,
                                                     const Eigen::Vector2d& first_mm,
                                                     std::int64_t n_holes);

enum class NibbleOrder : std::uint8_t {
  Alternating,  ///< NONIBO: the ends, then the middles between the holes drilled so far
  Sequential,   ///< NIBO: hole beside hole, at most 0.381 mm apart
};

struct Nibbling {
  NibbleOrder order = NibbleOrder::Alternating;
  /// Greatest height of the cusps between neighbouring holes above the wall (CNC command NIB).
  /// Smaller is smoother and takes more holes. Alternating order only: the other has its distance.
  double roughness_mm = 0.013;
};

/// G84: a big hole of overlapping small ones, beginning on the side of +x.
///
/// The holes' centres lie on a circle of radius r - d / 2. Alternating: as many holes as leave
/// cusps below the roughness, but a power of two; first the one at +x, then the opposite one, the
/// quarters and so on, each pass counterclockwise. Sequential: counterclockwise, the holes'
/// distances even and at most 0.381 mm.
///
/// Fails  radius_mm below 0.5; a tool whose diameter is not above zero, or larger than radius_mm;
///        a roughness not above zero
/// Source SIEB & MEYER manual, G84; Glossary, Nibbling
/// See    tests/program/sieb_meyer/figures/drill_patterns_test.cc
tl::expected<HoleSequence, std::string> nibbled_circle(const Eigen::Vector2d& center_mm,
                                                       double radius_mm,
                                                       double tool_diameter_mm,
                                                       const Nibbling& nibbling = {});

/// G85: a slot of overlapping holes, the first and the last of them in the programmed points.
///
/// Alternating: as many even steps as leave cusps below the roughness, but a power of two; both
/// ends, then the middle, the quarters and so on, each pass from start to end. Sequential: from
/// start to end in even steps of at most 0.381 mm. A slot of no length is one hole.
///
/// In     tool_diameter_mm: Alternating only
/// Fails  a tool diameter or a roughness that is needed and not above zero
/// Source SIEB & MEYER manual, G85; Glossary, Nibbling (hole order 1 6 4 7 3 8 5 9 2)
/// See    tests/program/sieb_meyer/figures/drill_patterns_test.cc
tl::expected<HoleSequence, std::string> nibbled_slot(const Eigen::Vector2d& start_mm,
                                                     const Eigen::Vector2d& end_mm,
                                                     double tool_diameter_mm,
                                                     const Nibbling& nibbling = {});

}  // namespace panelcal::sieb_meyer
