// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/figures/drill_patterns.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "calib/base/units.h"
#include "program/sieb_meyer/figures/refusal.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

using Holes = tl::expected<HoleSequence, std::string>;

constexpr double kStandardPitch_mm = inch(0.1).in_mm();
constexpr double kLeastCircle_mm = 0.5;
constexpr double kSequentialStep_mm = 0.381;
constexpr double kPatternCountNoise = 1e-6;     // what a ratio of two lengths may be off
constexpr double kPatternCoincident_mm = 1e-9;  // two holes that no machine tells apart

tl::unexpected<std::string> too_many_holes() {
  return refusal(fmt::format("too many holes; expected at most {:g}", kMaxHoles));
}

/// The corners and pitches of a V1 or V3: a is programmed, a and b end the first row, c lies beside
/// b at the programmed diagonal corner or near it.
struct Grid {
  Eigen::Vector2d a_mm;
  Eigen::Vector2d b_mm;
  Eigen::Vector2d c_mm;
  std::int64_t n_along;
  std::int64_t n_across;
};

/// "Programmed with an accuracy of +-1.27 mm" (manual, V1): there both places of the grid may be
/// meant, and a control may take either.
bool is_half_way(double n_pitches) {
  return std::abs(n_pitches - std::floor(n_pitches) - 0.5) <= kPatternCountNoise;
}

tl::expected<Grid, std::string> grid_between(const Eigen::Vector2d& first_mm,
                                             const Eigen::Vector2d& second_mm,
                                             std::optional<std::int64_t> n_in_row) {
  const Eigen::Vector2d diagonal_mm = second_mm - first_mm;
  if (!diagonal_mm.allFinite()) return not_finite();
  if (diagonal_mm.cwiseAbs().minCoeff() <= kPatternCoincident_mm) {
    return refusal(fmt::format("the corners are {:.6g} by {:.6g} mm apart; expected opposite ones",
                               std::abs(diagonal_mm.x()),
                               std::abs(diagonal_mm.y())));
  }
  if (n_in_row && *n_in_row < 2) {
    return refusal(fmt::format("W is {}; expected at least 2 holes in a row", *n_in_row));
  }
  const bool is_falling = (diagonal_mm.x() < 0) != (diagonal_mm.y() < 0);
  const int along = is_falling ? 0 : 1;
  const int across = 1 - along;
  const double length_mm = std::abs(diagonal_mm[along]);
  const double distance_mm = std::abs(diagonal_mm[across]);
  const double pitch_mm =
      n_in_row ? length_mm / static_cast<double>(*n_in_row - 1) : kStandardPitch_mm;
  for (const double side_mm : {length_mm, distance_mm}) {
    if (!is_half_way(side_mm / pitch_mm)) continue;
    return refusal(fmt::format(
        "the corners are {:.6g} mm apart, half way between two places of the {:.6g} mm grid; "
        "expected them nearer to one",
        side_mm,
        pitch_mm));
  }
  const double n_along = std::round(length_mm / pitch_mm);
  const double n_across = std::round(distance_mm / pitch_mm);
  if (n_along < 1 || n_across < 1) {
    return refusal(fmt::format(
        "the rows are {:.6g} mm long and {:.6g} mm apart; expected at least half a pitch of {:.6g} "
        "mm both",
        length_mm,
        distance_mm,
        pitch_mm));
  }
  if (!(2 * (n_along + 1) <= kMaxHoles) || !(2 * (n_along + n_across) <= kMaxHoles)) {
    return too_many_holes();
  }
  Grid grid{first_mm, first_mm, first_mm, std::llround(n_along), std::llround(n_across)};
  // With W the rows end exactly where they are programmed to.
  grid.b_mm[along] = n_in_row
                         ? second_mm[along]
                         : first_mm[along] + std::copysign(n_along * pitch_mm, diagonal_mm[along]);
  grid.c_mm = grid.b_mm;
  grid.c_mm[across] += std::copysign(n_across * pitch_mm, diagonal_mm[across]);
  return grid;
}

tl::unexpected<std::string> no_pattern_tool(double diameter_mm) {
  return refusal(
      fmt::format("the tool's diameter is {:.6g} mm; expected one above 0", diameter_mm));
}

tl::unexpected<std::string> no_roughness(double roughness_mm) {
  return refusal(fmt::format("the edge roughness is {:.6g} mm; expected above 0", roughness_mm));
}

}  // namespace

Holes dual_row(const Eigen::Vector2d& first_mm,
               const Eigen::Vector2d& second_mm,
               std::optional<std::int64_t> n_in_row) {
  const auto grid = grid_between(first_mm, second_mm, n_in_row);
  if (!grid) return refusal(grid.error());
  const Eigen::Vector2d d_mm = grid->a_mm + (grid->c_mm - grid->b_mm);
  return HoleSequence::rows(grid->a_mm, grid->b_mm, grid->c_mm, d_mm, grid->n_along);
}

Holes single_row(const Eigen::Vector2d& first_mm,
                 const Eigen::Vector2d& last_mm,
                 std::int64_t n_holes) {
  const double length_mm = (last_mm - first_mm).norm();
  if (!all_finite({length_mm})) return not_finite();
  const bool is_one_place = length_mm <= kPatternCoincident_mm;
  if (n_holes == 1 && is_one_place) return HoleSequence::passes(first_mm, last_mm, 0, 0);
  if (n_holes < 2) {
    return refusal(fmt::format("W is {}; expected at least the first and the last hole", n_holes));
  }
  if (is_one_place) {
    return refusal(fmt::format("{} holes in one place; expected two different points", n_holes));
  }
  if (static_cast<double>(n_holes) > kMaxHoles) return too_many_holes();
  return HoleSequence::passes(first_mm, last_mm, n_holes - 1, n_holes - 1);
}

Holes quadruple_row(const Eigen::Vector2d& first_mm,
                    const Eigen::Vector2d& second_mm,
                    std::optional<std::int64_t> n_in_row) {
  const auto grid = grid_between(first_mm, second_mm, n_in_row);
  if (!grid) return refusal(grid.error());
  return HoleSequence::outline(grid->a_mm, grid->b_mm, grid->c_mm, grid->n_along, grid->n_across);
}

Holes circular_row(const Eigen::Vector2d& center_mm,
                   const Eigen::Vector2d& first_mm,
                   std::int64_t n_holes) {
  const Eigen::Vector2d spoke_mm = first_mm - center_mm;
  const double radius_mm = spoke_mm.norm();
  if (!all_finite({radius_mm})) return not_finite();
  if (n_holes < 1) return refusal(fmt::format("W is {}; expected at least 1 hole", n_holes));
  if (radius_mm <= kPatternCoincident_mm) {
    return refusal("the hole on the circle is its centre; expected two different points");
  }
  if (static_cast<double>(n_holes) > kMaxHoles) return too_many_holes();
  return HoleSequence::ring(center_mm, spoke_mm, n_holes);
}

Holes nibbled_circle(const Eigen::Vector2d& center_mm,
                     double radius_mm,
                     double tool_diameter_mm,
                     const Nibbling& nibbling) {
  if (!all_finite(
          {center_mm.x(), center_mm.y(), radius_mm, tool_diameter_mm, nibbling.roughness_mm})) {
    return not_finite();
  }
  if (radius_mm < kLeastCircle_mm - kPatternCoincident_mm) {
    return refusal(fmt::format(
        "the circle's radius is {:.6g} mm; expected at least {:g} mm", radius_mm, kLeastCircle_mm));
  }
  if (!(tool_diameter_mm > 0)) return no_pattern_tool(tool_diameter_mm);
  if (tool_diameter_mm > radius_mm + kPatternCoincident_mm) {
    return refusal(
        fmt::format("the tool's diameter is {:.6g} mm; expected at most the circle's radius of "
                    "{:.6g} mm",
                    tool_diameter_mm,
                    radius_mm));
  }
  const double path_mm = radius_mm - 0.5 * tool_diameter_mm;
  const Eigen::Vector2d first_mm(path_mm, 0);
  if (nibbling.order == NibbleOrder::Sequential) {
    // The step is a chord: path_mm >= radius_mm / 2 makes it less than the diameter.
    const double turn_rad = 2 * std::asin(0.5 * kSequentialStep_mm / path_mm);
    const double n_holes = std::ceil(2 * std::numbers::pi / turn_rad - kPatternCountNoise);
    if (!(n_holes <= kMaxHoles)) return too_many_holes();
    return HoleSequence::ring(center_mm, first_mm, std::llround(n_holes));
  }
  if (!(nibbling.roughness_mm > 0)) return no_roughness(nibbling.roughness_mm);
  const auto n_holes = ring_holes(path_mm, tool_diameter_mm, nibbling.roughness_mm);
  if (!n_holes) return too_many_holes();
  const auto n_even = std::bit_ceil(static_cast<std::uint64_t>(*n_holes));
  return HoleSequence::ring_passes(center_mm, first_mm, static_cast<std::int64_t>(n_even));
}

Holes nibbled_slot(const Eigen::Vector2d& start_mm,
                   const Eigen::Vector2d& end_mm,
                   double tool_diameter_mm,
                   const Nibbling& nibbling) {
  const double length_mm = (end_mm - start_mm).norm();
  const bool is_sequential = nibbling.order == NibbleOrder::Sequential;
  if (!all_finite({length_mm})) return not_finite();
  if (!is_sequential) {
    if (!all_finite({tool_diameter_mm, nibbling.roughness_mm})) return not_finite();
    if (!(tool_diameter_mm > 0)) return no_pattern_tool(tool_diameter_mm);
    if (!(nibbling.roughness_mm > 0)) return no_roughness(nibbling.roughness_mm);
  }
  if (length_mm <= kPatternCoincident_mm) return HoleSequence::passes(start_mm, end_mm, 0, 0);
  if (is_sequential) {
    const double n_steps =
        std::max(1.0, std::ceil(length_mm / kSequentialStep_mm - kPatternCountNoise));
    if (!(n_steps < kMaxHoles)) return too_many_holes();
    return HoleSequence::passes(start_mm, end_mm, std::llround(n_steps), std::llround(n_steps));
  }
  const auto n_steps = slot_steps(length_mm, 1, tool_diameter_mm, nibbling.roughness_mm);
  if (!n_steps) return too_many_holes();
  return HoleSequence::passes(start_mm, end_mm, 1, *n_steps);
}

}  // namespace panelcal::sieb_meyer
