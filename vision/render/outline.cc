// SPDX-License-Identifier: Apache-2.0
#include "vision/render/outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace panelcal::internal {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTurn = 2 * kPi;

/// Spacing of nodes on closed curves in sigmas of the blur: the trapezoid rule's error is then
/// about exp(-(2 pi / 0.9)^2 / 2) = 3e-11, and still 3e-9 where a lens stretches by 10 %.
constexpr double kNodeSpacing = 0.9;
/// Gauss-Legendre of order 6 on panels of 2 sigmas: error 2e-8 of a pixel per panel.
constexpr double kPanelSigmas = 2;
constexpr double kPanelAngle = kPi / 8;  // of an arc: its own curvature must be resolved, too
constexpr std::array kPlaces = {-0.9324695142031521,
                                -0.6612093864662645,
                                -0.2386191860831969,
                                0.2386191860831969,
                                0.6612093864662645,
                                0.9324695142031521};
constexpr std::array kWeights = {0.1713244923791704,
                                 0.3607615730481386,
                                 0.4679139345726910,
                                 0.4679139345726910,
                                 0.3607615730481386,
                                 0.1713244923791704};
/// More nodes than this belong to a feature that is far larger than any picture.
constexpr double kMaxPieces = 1e6;

int pieces(double n) {
  return n > 0 ? 1 + static_cast<int>(std::min(n, kMaxPieces)) : 1;  // 1 for NaN, too
}

/// The mapping mirrors (y is up on the board, down in a picture): what is to the left of the way on
/// the board is to its right in the picture, hence the sign.
bool add_node(const SceneProjection& projection,
              const Eigen::Vector2d& at_mm,
              const Eigen::Vector2d& step_mm,
              std::vector<OutlineNode>& nodes) {
  const auto u_px = projection.image_of(at_mm);
  if (!u_px) return false;
  const Eigen::Matrix2d j = projection.jacobian(*u_px);
  const double det = j(0, 0) * j(1, 1) - j(0, 1) * j(1, 0);
  nodes.push_back({*u_px, (j(1, 0) * step_mm.x() - j(0, 0) * step_mm.y()) / det});
  return true;
}

bool add_closed(const SceneProjection& projection,
                const Arc& arc,
                double blur_px,
                std::vector<OutlineNode>& nodes) {
  const double length_px = kTurn * arc.rim.speed_mm() / projection.scale_mm_per_px();
  const int n = 31 + 8 * arc.rim.highest_order() + pieces(length_px / (kNodeSpacing * blur_px));
  const double step_rad = (arc.to_rad - arc.from_rad) / n;
  for (int i = 0; i < n; ++i) {
    const double angle_rad = arc.from_rad + i * step_rad;
    if (!add_node(projection, arc.at(angle_rad), step_rad * arc.derivative(angle_rad), nodes)) {
      return false;
    }
  }
  return true;
}

bool add_open(const SceneProjection& projection,
              const Arc& arc,
              double blur_px,
              std::vector<OutlineNode>& nodes) {
  const double span_rad = arc.to_rad - arc.from_rad;
  const double length_px = std::abs(span_rad) * arc.rim.speed_mm() / projection.scale_mm_per_px();
  const int n =
      pieces(std::max(length_px / (kPanelSigmas * blur_px),
                      std::abs(span_rad) / kPanelAngle * std::max(1, arc.rim.highest_order())));
  const double panel_rad = span_rad / n;
  for (int i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < kPlaces.size(); ++k) {
      const double angle_rad = arc.from_rad + (i + 0.5 + 0.5 * kPlaces[k]) * panel_rad;
      const Eigen::Vector2d step_mm = 0.5 * kWeights[k] * panel_rad * arc.derivative(angle_rad);
      if (!add_node(projection, arc.at(angle_rad), step_mm, nodes)) return false;
    }
  }
  return true;
}

bool add_side(const SceneProjection& projection,
              const Side& side,
              double blur_px,
              std::vector<OutlineNode>& nodes) {
  const Eigen::Vector2d whole_mm = side.to - side.from;
  const int n = pieces(whole_mm.norm() / projection.scale_mm_per_px() / (kPanelSigmas * blur_px));
  const Eigen::Vector2d panel_mm = whole_mm / n;
  for (int i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < kPlaces.size(); ++k) {
      const Eigen::Vector2d at_mm = side.from + (i + 0.5 + 0.5 * kPlaces[k]) * panel_mm;
      const Eigen::Vector2d step_mm = 0.5 * kWeights[k] * side.weight * panel_mm;
      if (!add_node(projection, at_mm, step_mm, nodes)) return false;
    }
  }
  return true;
}

/// A feature's own axes.
struct Axes {
  explicit Axes(const Feature& feature)
      : center(feature.center.in_mm()),
        x(std::cos(feature.angle.in_rad()), std::sin(feature.angle.in_rad())),
        y(-x.y(), x.x()) {}

  Eigen::Vector2d at(double x_mm, double y_mm) const { return center + x_mm * x + y_mm * y; }

  Eigen::Vector2d center;
  Eigen::Vector2d x;
  Eigen::Vector2d y;
};

Outline box_outline(const Axes& axes, double x0, double x1, double y0, double y1) {
  const std::array corners = {axes.at(x0, y0), axes.at(x1, y0), axes.at(x1, y1), axes.at(x0, y1)};
  Outline outline;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    outline.sides.push_back({corners[i], corners[(i + 1) % corners.size()]});
  }
  return outline;
}

Outline ring_outline(const Feature& feature) {
  Outline outline;
  const Eigen::Vector2d& center = feature.center.in_mm();
  outline.arcs.push_back(
      {center, RoughCircle(feature.size.in_mm() / 2, feature.roughness), 0, kTurn});
  if (feature.shape != Feature::Shape::Ring || !(feature.inner_size > mm(0))) return outline;
  Roughness inner = feature.roughness;
  inner.seed += 1;  // burrs of the hole are not those of the pad
  outline.arcs.push_back({center + feature.hole_offset.in_mm(),
                          RoughCircle(feature.inner_size.in_mm() / 2, inner),
                          kTurn,
                          0});
  return outline;
}

Outline stadium_outline(const Feature& feature) {
  const Axes axes(feature);
  const double radius = feature.inner_size.in_mm() / 2;
  const double straight = std::max(0.0, feature.size.in_mm() / 2 - radius);
  const double turn = feature.angle.in_rad();
  const RoughCircle end(radius, {});
  Outline outline;
  outline.sides = {{axes.at(-straight, -radius), axes.at(straight, -radius)},
                   {axes.at(straight, radius), axes.at(-straight, radius)}};
  outline.arcs = {{axes.at(straight, 0), end, turn - kPi / 2, turn + kPi / 2},
                  {axes.at(-straight, 0), end, turn + kPi / 2, turn + 3 * kPi / 2}};
  return outline;
}

Outline picture_outline(const Feature& feature) {
  if (!feature.picture || feature.picture->image.empty()) return {};
  const Image& image = feature.picture->image;
  const double step_mm = feature.size.in_mm() / image.width();
  const Eigen::Vector2d& reference = feature.picture->reference_px;
  return box_outline(Axes(feature),
                     step_mm * (-0.5 - reference.x()),
                     step_mm * (image.width() - 0.5 - reference.x()),
                     step_mm * (reference.y() + 0.5 - image.height()),
                     step_mm * (reference.y() + 0.5));
}

/// The edges along one set of grid lines, joined where they weigh the same.
template <class Weight, class Place>
void add_lines(std::size_t n_lines,
               std::size_t n_steps,
               const std::vector<Length>& steps,
               Weight weight_at,
               Place place,
               Outline& outline) {
  for (std::size_t line = 0; line < n_lines; ++line) {
    for (std::size_t i = 0; i < n_steps;) {
      const double weight = weight_at(line, i);
      std::size_t end = i + 1;
      while (end < n_steps && weight_at(line, end) == weight) ++end;
      if (weight != 0) {
        outline.sides.push_back(
            {place(line, steps[i].in_mm()), place(line, steps[end].in_mm()), weight});
      }
      i = end;
    }
  }
}

}  // namespace

bool Arc::is_closed() const {
  return std::abs(to_rad - from_rad) == kTurn;
}

Eigen::Vector2d Arc::at(double angle_rad) const {
  return center +
         rim.radius_mm(angle_rad) * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
}

Eigen::Vector2d Arc::derivative(double angle_rad) const {
  const Eigen::Vector2d e(std::cos(angle_rad), std::sin(angle_rad));
  const Eigen::Vector2d r = rim.evaluate(angle_rad);
  return r.x() * Eigen::Vector2d(-e.y(), e.x()) + r.y() * e;
}

Outline cell_edges(const Feature& feature, std::span<const double> values) {
  const CellGrid& grid = *feature.cells;
  if (grid.x.size() < 2 || grid.y.size() < 2) return {};
  const std::size_t n_x = grid.x.size() - 1;
  const std::size_t n_y = grid.y.size() - 1;
  if (values.size() != n_x * n_y) return {};
  // One beyond the grid on either side, so that i - 1 and n need no special case.
  const auto value = [&](std::size_t i, std::size_t j) {
    return i < n_x && j < n_y ? values[j * n_x + i] : 0.0;
  };
  const Axes axes(feature);
  Outline outline;
  add_lines(
      n_x + 1,
      n_y,
      grid.y,
      [&](std::size_t i, std::size_t j) { return value(i - 1, j) - value(i, j); },
      [&](std::size_t i, double y_mm) { return axes.at(grid.x[i].in_mm(), y_mm); },
      outline);
  add_lines(
      n_y + 1,
      n_x,
      grid.x,
      [&](std::size_t j, std::size_t i) { return value(i, j) - value(i, j - 1); },
      [&](std::size_t j, double x_mm) { return axes.at(x_mm, grid.y[j].in_mm()); },
      outline);
  return outline;
}

Outline outline_of(const Feature& feature) {
  using Shape = Feature::Shape;
  switch (feature.shape) {
    case Shape::Disc:
    case Shape::Ring:
      return ring_outline(feature);
    case Shape::Rectangle: {
      const double x_mm = feature.size.in_mm() / 2;
      const double y_mm = feature.inner_size.in_mm() / 2;
      return box_outline(Axes(feature), -x_mm, x_mm, -y_mm, y_mm);
    }
    case Shape::Stadium:
      return stadium_outline(feature);
    case Shape::Picture:
      return picture_outline(feature);
    case Shape::Cells: {
      if (!feature.cells) return {};
      std::vector<double> opaque;
      for (const auto& level : feature.cells->levels) opaque.push_back(level ? 1 : 0);
      return cell_edges(feature, opaque);
    }
  }
  return {};
}

std::vector<OutlineNode> outline_nodes(const SceneProjection& projection,
                                       const Outline& outline,
                                       double blur_px) {
  std::vector<OutlineNode> nodes;
  for (const Side& side : outline.sides) {
    if (!add_side(projection, side, blur_px, nodes)) return {};
  }
  for (const Arc& arc : outline.arcs) {
    const bool is_drawn = arc.is_closed() ? add_closed(projection, arc, blur_px, nodes)
                                          : add_open(projection, arc, blur_px, nodes);
    if (!is_drawn) return {};
  }
  return nodes;
}

std::vector<Eigen::Vector2d> outline_places(const Outline& outline, Length spacing) {
  const double spacing_mm = spacing.in_mm();
  std::vector<Eigen::Vector2d> places;
  for (const Side& side : outline.sides) {
    const Eigen::Vector2d whole = side.to - side.from;
    const int n = pieces(whole.norm() / spacing_mm);
    for (int i = 0; i < n; ++i) places.push_back(side.from + (i + 0.5) / n * whole);
  }
  for (const Arc& arc : outline.arcs) {
    const double span_rad = arc.to_rad - arc.from_rad;
    const int n = pieces(std::abs(span_rad) * arc.rim.speed_mm() / spacing_mm);
    for (int i = 0; i < n; ++i) places.push_back(arc.at(arc.from_rad + (i + 0.5) / n * span_rad));
  }
  return places;
}

}  // namespace panelcal::internal
