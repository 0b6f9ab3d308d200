// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/patterns/canned_cycles.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <string_view>

#include "calib/base/units.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

constexpr double kMaxCount = kMaxHoles;
constexpr double kMaxCusp_mm = inch(0.0005).in_mm();
constexpr double kPlungeInside_mm = inch(0.01).in_mm();
constexpr double kRetractInside_mm = inch(0.1).in_mm();
constexpr double kCycleNoise_mm = 1e-6;       // what converted and added lengths may be off
constexpr double kCycleCountNoise = 1e-6;     // the same of a ratio of two lengths
constexpr double kCycleCoincident_mm = 1e-9;  // two holes that no machine tells apart

tl::unexpected<std::string> wrong(std::string what) {
  return tl::unexpected<std::string>(std::move(what));
}

tl::unexpected<std::string> too_many(std::string_view what) {
  return wrong(fmt::format("too many {}; expected at most {:g}", what, kMaxCount));
}

bool all_finite(std::initializer_list<double> numbers) {
  return std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); });
}

tl::unexpected<std::string> not_finite() {
  return wrong("a number is not finite; expected lengths in mm");
}

tl::unexpected<std::string> no_cycle_tool(double diameter_mm) {
  return wrong(fmt::format("the tool's diameter is {:.6g} mm; expected one above 0", diameter_mm));
}

}  // namespace

Cycle<HoleSequence> dual_in_line(const Eigen::Vector2d& corner_a_mm,
                                 const Eigen::Vector2d& corner_b_mm,
                                 double pitch_mm,
                                 double row_mm,
                                 double rounding_mm) {
  const Eigen::Vector2d size_mm = (corner_b_mm - corner_a_mm).cwiseAbs();
  const double x_mm = size_mm.x();
  const double y_mm = size_mm.y();
  if (!all_finite({x_mm, y_mm, pitch_mm, row_mm})) return not_finite();
  if (!(pitch_mm > 0) || !(row_mm > 0)) {
    return wrong(
        fmt::format("the holes are {:.6g} mm and the rows {:.6g} mm apart; expected both above 0",
                    pitch_mm,
                    row_mm));
  }
  const double slack_mm = rounding_mm + kCycleNoise_mm;
  const std::string corners = fmt::format("the corners are {:.6g} by {:.6g} mm apart", x_mm, y_mm);
  if (x_mm <= slack_mm || y_mm <= slack_mm) return wrong(corners + "; expected opposite corners");
  if (std::abs(x_mm - y_mm) <= slack_mm) {
    return wrong(corners + "; expected no square: the rows could run either way");
  }
  const bool fits_along_x = std::abs(y_mm - row_mm) <= slack_mm;
  const bool fits_along_y = std::abs(x_mm - row_mm) <= slack_mm;
  const bool along_x = fits_along_x == fits_along_y ? x_mm > y_mm : fits_along_x;
  const double length_mm = along_x ? x_mm : y_mm;
  const double between_mm = along_x ? y_mm : x_mm;
  const double contradicts_mm = std::abs(between_mm - row_mm);
  if (contradicts_mm > slack_mm && std::abs(length_mm - row_mm) <= contradicts_mm + slack_mm) {
    return wrong(corners +
                 fmt::format("; expected the {:.6g} mm between the rows in x or in y: they "
                             "could run either way",
                             row_mm));
  }
  const double n_pitches = std::round(length_mm / pitch_mm);
  if (n_pitches < 1 || std::abs(length_mm - n_pitches * pitch_mm) > slack_mm) {
    return wrong(
        fmt::format("the rows are {:.6g} mm long; expected a whole number of pitches of {:.6g} mm",
                    length_mm,
                    pitch_mm));
  }
  if (2 * (n_pitches + 1) > kMaxCount) return too_many("holes");
  const Eigen::Vector2d x_of_b_mm(corner_b_mm.x(), corner_a_mm.y());
  const Eigen::Vector2d y_of_b_mm(corner_a_mm.x(), corner_b_mm.y());
  const auto n = static_cast<std::int64_t>(n_pitches);
  const Eigen::Vector2d& a_end_mm = along_x ? x_of_b_mm : y_of_b_mm;
  const Eigen::Vector2d& b_end_mm = along_x ? y_of_b_mm : x_of_b_mm;
  return HoleSequence::rows(corner_a_mm, a_end_mm, corner_b_mm, b_end_mm, n);
}

bool has_row_spacing(const Eigen::Vector2d& corner_a_mm,
                     const Eigen::Vector2d& corner_b_mm,
                     double row_mm,
                     double rounding_mm) {
  const Eigen::Array2d size_mm = (corner_b_mm - corner_a_mm).cwiseAbs();
  return (size_mm - row_mm).abs().minCoeff() <= rounding_mm + kCycleNoise_mm;
}

Cycle<HoleSequence> eight_pin(const Eigen::Vector2d& a_mm,
                              const Eigen::Vector2d& b_mm,
                              double rounding_mm) {
  const Eigen::Vector2d apart_mm = (b_mm - a_mm).cwiseAbs();
  if (!apart_mm.allFinite()) return not_finite();
  const double slack_mm = rounding_mm + kCycleNoise_mm;
  const std::string holes =
      fmt::format("the holes are {:.6g} by {:.6g} mm apart", apart_mm.x(), apart_mm.y());
  if (apart_mm.maxCoeff() <= slack_mm) return wrong(holes + "; expected two opposite ones");
  if (apart_mm.minCoeff() > slack_mm) {
    return wrong(holes + "; expected a horizontal or vertical line through both");
  }
  return HoleSequence::ring(0.5 * (a_mm + b_mm), 0.5 * (a_mm - b_mm), 8);
}

Cycle<HoleSequence> canned_circle(const Eigen::Vector2d& center_mm,
                                  double diameter_mm,
                                  double tool_diameter_mm) {
  if (!all_finite({center_mm.x(), center_mm.y(), diameter_mm, tool_diameter_mm}))
    return not_finite();
  if (!(tool_diameter_mm > 0)) return no_cycle_tool(tool_diameter_mm);
  if (diameter_mm < 2 * tool_diameter_mm - kCycleCoincident_mm) {
    return wrong(fmt::format(
        "the circle's diameter is {:.6g} mm; expected at least twice the tool's {:.6g} mm",
        diameter_mm,
        tool_diameter_mm));
  }
  const double path_mm = 0.5 * (diameter_mm - tool_diameter_mm);
  const std::optional<std::int64_t> n_holes = ring_holes(path_mm, tool_diameter_mm, kMaxCusp_mm);
  if (!n_holes) return too_many("holes");
  return HoleSequence::ring(center_mm, {path_mm, 0}, *n_holes);
}

Cycle<HoleSequence> canned_slot(const Eigen::Vector2d& start_mm,
                                const Eigen::Vector2d& end_mm,
                                double tool_diameter_mm) {
  const double length_mm = (end_mm - start_mm).norm();
  if (!all_finite({length_mm, tool_diameter_mm})) return not_finite();
  if (!(tool_diameter_mm > 0)) return no_cycle_tool(tool_diameter_mm);
  if (length_mm <= kCycleCoincident_mm) return HoleSequence::passes(start_mm, end_mm, 0, 0);
  const double n_first = std::max(1.0, std::floor(length_mm / tool_diameter_mm + kCycleCountNoise));
  const std::optional<std::int64_t> n_steps =
      slot_steps(length_mm, n_first, tool_diameter_mm, kMaxCusp_mm);
  if (!n_steps) return too_many("holes");
  return HoleSequence::passes(start_mm, end_mm, static_cast<std::int64_t>(n_first), *n_steps);
}

Cycle<StepDepths> step_slot_depths(double initial_mm, double increment_mm) {
  if (!all_finite({initial_mm, increment_mm})) return not_finite();
  if (initial_mm < 0) {
    return wrong(fmt::format("the initial depth is {:.6g} mm; expected 0 or above", initial_mm));
  }
  if (increment_mm >= 0) {
    return wrong(
        fmt::format("the depth increment is {:.6g} mm; expected one below 0", increment_mm));
  }
  const double n_steps = std::ceil(initial_mm / -increment_mm - kCycleCountNoise);
  if (!(n_steps < kMaxCount)) return too_many("passes");
  return StepDepths(initial_mm, increment_mm, std::max<std::int64_t>(0, std::llround(n_steps)) + 1);
}

Cycle<RoutedCircle> routed_circle(const Eigen::Vector2d& center_mm,
                                  double radius_mm,
                                  double compensation_mm) {
  if (!all_finite({center_mm.x(), center_mm.y(), radius_mm, compensation_mm})) return not_finite();
  if (compensation_mm < 0) {
    return wrong(
        fmt::format("the compensation is {:.6g} mm; expected 0 or above", compensation_mm));
  }
  const double least_mm = 0.5 * compensation_mm + kPlungeInside_mm;
  if (radius_mm < least_mm - kCycleCoincident_mm) {
    return wrong(
        fmt::format("the radius is {:.6g} mm; expected at least {:.6g} mm", radius_mm, least_mm));
  }
  RoutedCircle circle;
  circle.radius_mm = std::max(radius_mm - 0.5 * compensation_mm, kPlungeInside_mm);
  const auto above_center = [&](double y_mm) -> Eigen::Vector2d {
    return center_mm + Eigen::Vector2d(0, y_mm);
  };
  circle.near_mm = above_center(-circle.radius_mm);
  circle.far_mm = above_center(circle.radius_mm);
  circle.plunge_mm = above_center(kPlungeInside_mm - circle.radius_mm);
  circle.retract_mm = above_center(std::max(circle.radius_mm - kRetractInside_mm, 0.0));
  return circle;
}

}  // namespace panelcal::excellon
