// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

namespace panelcal {

/// More holes than one command can mean; counts up to here are exact.
inline constexpr double kMaxHoles = 1e12;

/// The holes of a drill pattern, worked out one at a time so that memory does not grow with their
/// number. Programmed coordinates, mm.
///
/// See    tests/program/walk/execution/hole_sequence_test.cc
class HoleSequence {
 public:
  /// Two rows of n_pitches + 1 holes each, one after the other. n_pitches >= 1.
  static HoleSequence rows(const Eigen::Vector2d& first_from_mm,
                           const Eigen::Vector2d& first_to_mm,
                           const Eigen::Vector2d& second_from_mm,
                           const Eigen::Vector2d& second_to_mm,
                           std::int64_t n_pitches);
  /// Holes evenly spaced on the sides of the parallelogram a, b, c, a + c - b, in this order and
  /// once each. n_ab, n_bc: pitches of a side, >= 1.
  static HoleSequence outline(const Eigen::Vector2d& a_mm,
                              const Eigen::Vector2d& b_mm,
                              const Eigen::Vector2d& c_mm,
                              std::int64_t n_ab,
                              std::int64_t n_bc);
  /// Holes evenly spaced on a circle, counterclockwise from center + first on. n_holes >= 1.
  static HoleSequence ring(const Eigen::Vector2d& center_mm,
                           const Eigen::Vector2d& first_mm,
                           std::int64_t n_holes);
  /// The same holes in passes: the first one, the opposite one, then counterclockwise the middles
  /// between those drilled so far, again and again. n_holes = 2^k.
  static HoleSequence ring_passes(const Eigen::Vector2d& center_mm,
                                  const Eigen::Vector2d& first_mm,
                                  std::int64_t n_holes);
  /// Holes n_first even steps apart, then the middles between them, until there are n_steps steps.
  /// n_steps = n_first 2^k; no steps are one hole.
  static HoleSequence passes(const Eigen::Vector2d& start_mm,
                             const Eigen::Vector2d& end_mm,
                             std::int64_t n_first,
                             std::int64_t n_steps);

  std::int64_t size() const;
  /// Precondition: 0 <= i < size().
  Eigen::Vector2d operator[](std::int64_t i) const;

 private:
  enum class Shape : std::uint8_t { Rows, Outline, Ring, RingPasses, Passes };

  HoleSequence(Shape shape, std::int64_t n, std::int64_t n_first)
      : shape_(shape), n_(n), n_first_(n_first) {}
  Eigen::Vector2d on_row(std::int64_t i) const;
  Eigen::Vector2d on_outline(std::int64_t i) const;
  Eigen::Vector2d on_ring(std::int64_t i) const;
  Eigen::Vector2d in_ring_pass(std::int64_t i) const;
  Eigen::Vector2d in_pass(std::int64_t i) const;

  Shape shape_;
  std::int64_t n_;  // pitches of a row or half an outline, holes of a ring, steps of all passes
  std::int64_t n_first_;  // steps of the first pass, pitches of an outline's first side
  // The ends of both rows; the corners; a ring's centre and first spoke; start and end.
  std::array<Eigen::Vector2d, 4> mm_{};
};

/// Into how many steps a slot must be divided: n_first, doubled until the cusps that neighbouring
/// holes leave in the walls are lower than max_cusp_mm.
///
///   cusp = r - sqrt(r^2 - (step / 2)^2),   r half the tool's diameter; holes that do not meet
///   leave more than any limit
///
/// In     all > 0
/// Out    absent if kMaxHoles steps do not do
/// See    tests/program/excellon/patterns/canned_cycles_test.cc,
/// tests/program/walk/execution/hole_sequence_test.cc
std::optional<std::int64_t> slot_steps(double length_mm,
                                       double n_first,
                                       double tool_diameter_mm,
                                       double max_cusp_mm);

/// Number of holes on a circle that meet and leave cusps lower than max_cusp_mm in the wall of the
/// big hole.
///
/// In     path_radius_mm: of the circle that the holes' centres are on, at least half of the tool's
///        diameter; all > 0
/// Out    the least number; absent beyond kMaxHoles
/// See    tests/program/excellon/patterns/canned_cycles_test.cc,
/// tests/program/walk/execution/hole_sequence_test.cc
std::optional<std::int64_t> ring_holes(double path_radius_mm,
                                       double tool_diameter_mm,
                                       double max_cusp_mm);

}  // namespace panelcal
