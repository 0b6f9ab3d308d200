// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/figures/corner_rounding.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "calib/base/plane_vectors.h"
#include "program/sieb_meyer/figures/refusal.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

using internal::cross;
using internal::left_of;
using Rounding = tl::expected<Arc, std::string>;

constexpr double kMeets_mm = 1e-6;
constexpr double kCornerNoise_mm = 1e-9;  // what a tangent point may lie beyond a piece's end
constexpr double kAngleNoise_rad = 1e-12;
constexpr double kStraight_rad = 1e-6;  // less than this is no corner, or a turn straight back

/// The angle counterclockwise from a to b, 0 to 2 pi.
double turn_rad(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const double turn = std::atan2(cross(a, b), a.dot(b));
  return turn < -kAngleNoise_rad ? turn + 2 * std::numbers::pi : std::max(turn, 0.0);
}

double sense_of(const ContourPiece& arc) {
  return arc.clockwise ? -1 : 1;
}

/// The direction of travel at a point of a piece.
Eigen::Vector2d direction_at(const ContourPiece& piece, const Eigen::Vector2d& point_mm) {
  if (!piece.center_mm) return (piece.end_mm - piece.start_mm).normalized();
  return sense_of(piece) * left_of(point_mm - *piece.center_mm).normalized();
}

ContourPiece reversed(ContourPiece piece) {
  std::swap(piece.start_mm, piece.end_mm);
  piece.clockwise = !piece.clockwise;
  return piece;
}

bool is_finite(const ContourPiece& piece) {
  return piece.start_mm.allFinite() && piece.end_mm.allFinite() &&
         (!piece.center_mm || piece.center_mm->allFinite());
}

bool has_length(const ContourPiece& piece) {
  const Eigen::Vector2d from_mm = piece.center_mm.value_or(piece.end_mm);
  return (piece.start_mm - from_mm).norm() > kCornerNoise_mm;
}

tl::unexpected<std::string> too_short(double needed_mm, double length_mm) {
  return refusal(fmt::format(
      "the rounding begins or ends {:.6g} mm from the corner; expected at most the {:.6g} mm of "
      "the adjacent piece",
      needed_mm,
      length_mm));
}

tl::unexpected<std::string> fits_nowhere(double radius_mm) {
  return refusal(fmt::format(
      "no arc of radius {:.6g} mm touches both pieces; expected a smaller one", radius_mm));
}

Rounding between_lines(const ContourPiece& first, const ContourPiece& second, double radius_mm) {
  const Eigen::Vector2d u = direction_at(first, first.end_mm);
  const Eigen::Vector2d v = direction_at(second, second.start_mm);
  const double sine = cross(u, v);
  const double tangent_mm = radius_mm * std::abs(std::tan(0.5 * std::atan2(sine, u.dot(v))));
  for (const ContourPiece* piece : {&first, &second}) {
    const double length_mm = (piece->end_mm - piece->start_mm).norm();
    if (!(tangent_mm <= length_mm + kCornerNoise_mm)) return too_short(tangent_mm, length_mm);
  }
  Arc arc;
  arc.clockwise = sine < 0;
  arc.start_mm = first.end_mm - tangent_mm * u;
  arc.end_mm = first.end_mm + tangent_mm * v;
  arc.center_mm = arc.start_mm + (arc.clockwise ? -radius_mm : radius_mm) * left_of(u);
  return arc;
}

/// With E the corner, u the line's direction, s and z the senses of rounding and arc (1 or -1), the
/// centre is Q = E - t u + s r left(u), and |Q - C| = |R - s z r|: a quadratic equation for t.
Rounding from_line_to_arc(const ContourPiece& line, const ContourPiece& arc, double radius_mm) {
  const Eigen::Vector2d& corner_mm = arc.start_mm;
  const Eigen::Vector2d spoke_mm = corner_mm - *arc.center_mm;
  const Eigen::Vector2d u = direction_at(line, line.end_mm);
  const Eigen::Vector2d v = direction_at(arc, corner_mm);
  const double side = cross(u, v) < 0 ? -1 : 1;
  const double same_way = side * sense_of(arc);
  const double arc_radius_mm = spoke_mm.norm();
  // A bigger circle around the arc's would have the corner, and so the line, in its inside; of one
  // that almost coincides with it the tangent point is lost in rounding.
  const double apart_mm = arc_radius_mm - same_way * radius_mm;
  if (apart_mm <= kCornerNoise_mm) return fits_nowhere(radius_mm);

  // t^2 - 2 half_sum t + product = 0. With one positive and one negative root t is the positive
  // one; of two positive ones it is the smaller: the other would cut off the far end of the chord.
  const double half_sum_mm = u.dot(spoke_mm);
  const double product_mm2 = same_way * radius_mm * arc_radius_mm * (u - v).squaredNorm();
  const double root_mm2 = half_sum_mm * half_sum_mm - product_mm2;
  if (!(root_mm2 >= 0)) return fits_nowhere(radius_mm);
  // half_sum has the sign of same_way, so nothing cancels.
  const double t_mm = product_mm2 / (half_sum_mm + same_way * std::sqrt(root_mm2));
  if (!(t_mm >= 0)) return fits_nowhere(radius_mm);
  const double line_mm = (line.end_mm - line.start_mm).norm();
  if (t_mm > line_mm + kCornerNoise_mm) return too_short(t_mm, line_mm);

  Arc rounding;
  rounding.clockwise = side < 0;
  rounding.start_mm = corner_mm - t_mm * u;
  rounding.center_mm = rounding.start_mm + side * radius_mm * left_of(u);
  const Eigen::Vector2d outward = (rounding.center_mm - *arc.center_mm).normalized();
  rounding.end_mm = rounding.center_mm + same_way * radius_mm * outward;

  const Eigen::Vector2d last_mm = arc.end_mm - *arc.center_mm;
  const double full_rad = arc.clockwise ? turn_rad(last_mm, spoke_mm) : turn_rad(spoke_mm, last_mm);
  const double used_rad = arc.clockwise ? turn_rad(outward, spoke_mm) : turn_rad(spoke_mm, outward);
  const bool is_full_circle = (arc.end_mm - corner_mm).norm() <= kCornerNoise_mm;
  const double length_mm = arc_radius_mm * (is_full_circle ? 2 * std::numbers::pi : full_rad);
  if (arc_radius_mm * used_rad > length_mm + kCornerNoise_mm) {
    return too_short(arc_radius_mm * used_rad, length_mm);
  }
  return rounding;
}

}  // namespace

Rounding round_corner(const ContourPiece& first, const ContourPiece& second, double radius_mm) {
  if (!is_finite(first) || !is_finite(second) || !std::isfinite(radius_mm)) return not_finite();
  if (!(radius_mm > 0)) {
    return refusal(fmt::format("the rounding's radius is {:.6g} mm; expected above 0", radius_mm));
  }
  const double gap_mm = (second.start_mm - first.end_mm).norm();
  if (!(gap_mm <= kMeets_mm)) {
    return refusal(fmt::format("the pieces are {:.6g} mm apart; expected a common corner", gap_mm));
  }
  if (!has_length(first) || !has_length(second)) {
    return refusal("a piece beside the corner has no length; expected a line or an arc");
  }
  if (first.center_mm && second.center_mm) {
    return refusal("the corner is between two arcs; expected a line on one side at least");
  }
  const Eigen::Vector2d u = direction_at(first, first.end_mm);
  const Eigen::Vector2d v = direction_at(second, second.start_mm);
  const double turn = std::abs(std::atan2(cross(u, v), u.dot(v)));
  if (turn < kStraight_rad) {
    return refusal("the second piece goes straight on; expected a corner to be rounded");
  }
  if (turn > std::numbers::pi - kStraight_rad) {
    return refusal("the second piece turns straight back; expected a corner to be rounded");
  }
  if (second.center_mm) return from_line_to_arc(first, second, radius_mm);
  if (!first.center_mm) return between_lines(first, second, radius_mm);
  // The same corner, travelled the other way.
  Rounding rounding = from_line_to_arc(reversed(second), reversed(first), radius_mm);
  if (rounding) {
    std::swap(rounding->start_mm, rounding->end_mm);
    rounding->clockwise = !rounding->clockwise;
  }
  return rounding;
}

}  // namespace panelcal::sieb_meyer
