// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/figures/rout_figures.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "program/sieb_meyer/figures/refusal.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

using Figure = tl::expected<FigurePath, std::string>;

constexpr double kRingStep = 0.7;  // of the cutter's diameter
constexpr double kMaxRings = 10000;
constexpr double kFigureCountNoise = 1e-9;  // what a ratio of two lengths may be off
constexpr double kLeastMove_mm = 1e-9;
constexpr double kSine45 = 0.5 * std::numbers::sqrt2;

/// Puts pieces together so that they chain exactly. Points are given relative to the figure's
/// centre and for a counterclockwise figure; a clockwise one is mirrored in `mirror`.
class PathBuilder {
 public:
  PathBuilder(const Eigen::Vector2d& center_mm, const Eigen::Vector2d& mirror)
      : center_mm_(center_mm), mirror_(mirror), clockwise_(mirror.minCoeff() < 0) {}

  void plunge(const Eigen::Vector2d& point_mm) {
    path_.plunge_mm = placed(point_mm);
    at_mm_ = path_.plunge_mm;
  }
  void line(const Eigen::Vector2d& to_mm) {
    const Eigen::Vector2d end_mm = placed(to_mm);
    if ((end_mm - at_mm_).norm() <= kLeastMove_mm) return;
    push({at_mm_, end_mm, 0.5 * (at_mm_ + end_mm), false, true});
  }
  void arc(const Eigen::Vector2d& to_mm, const Eigen::Vector2d& around_mm) {
    push({at_mm_, placed(to_mm), placed(around_mm), clockwise_, false});
  }
  /// All round the figure's centre, from from_mm, where the cutter is, in two halves.
  void circle(const Eigen::Vector2d& from_mm) {
    arc(-from_mm, Eigen::Vector2d::Zero());
    arc(from_mm, Eigen::Vector2d::Zero());
  }
  /// All round, from the middle of the top side, where the cutter is.
  void rectangle(double half_x_mm, double half_y_mm) {
    line({-half_x_mm, half_y_mm});
    line({-half_x_mm, -half_y_mm});
    line({half_x_mm, -half_y_mm});
    line({half_x_mm, half_y_mm});
    line({0, half_y_mm});
  }
  FigurePath take() { return std::move(path_); }

 private:
  Eigen::Vector2d placed(const Eigen::Vector2d& point_mm) const {
    return center_mm_ + mirror_.cwiseProduct(point_mm);
  }
  void push(const Arc& piece) {
    path_.pieces.push_back(piece);
    at_mm_ = piece.end_mm;
  }

  Eigen::Vector2d center_mm_;
  Eigen::Vector2d mirror_;
  bool clockwise_;
  Eigen::Vector2d at_mm_ = Eigen::Vector2d::Zero();
  FigurePath path_;
};

Eigen::Vector2d mirror_left_right(Turn turn) {
  return {turn == Turn::Clockwise ? -1 : 1, 1};
}

Eigen::Vector2d mirror_up_down(Turn turn) {
  return {1, turn == Turn::Clockwise ? -1 : 1};
}

std::optional<std::string> figure_fault(const Eigen::Vector2d& center_mm,
                                        double size_mm,
                                        double cutter_diameter_mm) {
  if (!all_finite({center_mm.x(), center_mm.y(), size_mm, cutter_diameter_mm})) {
    return not_finite().value();
  }
  if (!(cutter_diameter_mm > 0)) {
    return fmt::format("the cutter's diameter is {:.6g} mm; expected one above 0",
                       cutter_diameter_mm);
  }
  if (!(size_mm > 0)) {
    return fmt::format("the radius or a side is {:.6g} mm; expected one above 0", size_mm);
  }
  return std::nullopt;
}

/// Number of rings inside a path whose inner radius is half_mm, so that they and it are evenly
/// spaced; step_mm is their distance.
struct Rings {
  int n = 0;
  double step_mm = 0;
};

tl::expected<Rings, std::string> rings_inside(double half_mm, double cutter_diameter_mm, Cut cut) {
  if (cut == Cut::Contour) return Rings{};
  // The cutter meets itself across the innermost ring as it meets its neighbours.
  const double least_mm = 0.5 * kRingStep * cutter_diameter_mm;
  const double n =
      std::ceil((half_mm - least_mm) / (kRingStep * cutter_diameter_mm) - kFigureCountNoise);
  if (n < 1) return Rings{};
  if (!(n <= kMaxRings)) {
    return refusal(
        fmt::format("clearing the area takes {:.6g} rings; expected at most {:g}", n, kMaxRings));
  }
  return Rings{static_cast<int>(n), (half_mm - least_mm) / n};
}

}  // namespace

Figure circle_inside(const Eigen::Vector2d& center_mm,
                     double radius_mm,
                     double cutter_diameter_mm,
                     Turn turn,
                     Cut cut) {
  if (const auto fault = figure_fault(center_mm, radius_mm, cutter_diameter_mm))
    return refusal(*fault);
  const double path_mm = radius_mm - 0.5 * cutter_diameter_mm;
  if (path_mm <= kLeastMove_mm) {
    return refusal(
        fmt::format("the circle's radius is {:.6g} mm; expected more than half of the "
                    "cutter's diameter of {:.6g} mm",
                    radius_mm,
                    cutter_diameter_mm));
  }
  const auto rings = rings_inside(path_mm, cutter_diameter_mm, cut);
  if (!rings) return refusal(rings.error());
  PathBuilder path(center_mm, mirror_left_right(turn));
  const double k_mm = 0.5 * path_mm;
  const Eigen::Vector2d plunge_mm(k_mm * kSine45, k_mm * (1 + kSine45));
  const Eigen::Vector2d top_mm(0, path_mm);
  const Eigen::Vector2d approach_center_mm(0, k_mm);
  path.plunge(plunge_mm);
  for (int i = rings->n; i >= 1; --i) {
    const Eigen::Vector2d ring_top_mm(0, path_mm - i * rings->step_mm);
    path.line(ring_top_mm);
    path.circle(ring_top_mm);
  }
  path.line(plunge_mm);
  path.arc(top_mm, approach_center_mm);
  path.circle(top_mm);
  path.arc({-plunge_mm.x(), plunge_mm.y()}, approach_center_mm);
  return path.take();
}

Figure disk_outside(const Eigen::Vector2d& center_mm,
                    double radius_mm,
                    double cutter_diameter_mm,
                    Turn turn) {
  if (const auto fault = figure_fault(center_mm, radius_mm, cutter_diameter_mm))
    return refusal(*fault);
  const double cutter_radius_mm = 0.5 * cutter_diameter_mm;
  const Eigen::Vector2d left_mm(-(radius_mm + cutter_radius_mm), 0);
  const Eigen::Vector2d beside_mm(0, cutter_radius_mm);
  PathBuilder path(center_mm, mirror_up_down(turn));
  path.plunge(left_mm + beside_mm);
  path.line(left_mm);
  path.circle(left_mm);
  path.line(left_mm - beside_mm);
  return path.take();
}

Figure rectangle_inside(const Eigen::Vector2d& center_mm,
                        const Eigen::Vector2d& sides_mm,
                        double cutter_diameter_mm,
                        Turn turn,
                        Cut cut) {
  for (const double side_mm : {sides_mm.x(), sides_mm.y()}) {
    if (const auto fault = figure_fault(center_mm, side_mm, cutter_diameter_mm))
      return refusal(*fault);
  }
  const double half_x_mm = 0.5 * (sides_mm.x() - cutter_diameter_mm);
  const double half_y_mm = 0.5 * (sides_mm.y() - cutter_diameter_mm);
  if (std::min(half_x_mm, half_y_mm) <= kLeastMove_mm) {
    return refusal(
        fmt::format("the sides are {:.6g} and {:.6g} mm; expected more than the cutter's "
                    "diameter of {:.6g} mm",
                    sides_mm.x(),
                    sides_mm.y(),
                    cutter_diameter_mm));
  }
  const auto rings = rings_inside(std::min(half_x_mm, half_y_mm), cutter_diameter_mm, cut);
  if (!rings) return refusal(rings.error());
  PathBuilder path(center_mm, mirror_left_right(turn));
  const Eigen::Vector2d plunge_mm(0, 0.5 * half_y_mm);
  path.plunge(plunge_mm);
  for (int i = rings->n; i >= 0; --i) {
    const double inside_mm = i * rings->step_mm;
    path.line({0, half_y_mm - inside_mm});
    path.rectangle(half_x_mm - inside_mm, half_y_mm - inside_mm);
  }
  path.line(plunge_mm);
  return path.take();
}

}  // namespace panelcal::sieb_meyer
