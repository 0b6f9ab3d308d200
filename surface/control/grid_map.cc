// SPDX-License-Identifier: Apache-2.0
#include "surface/control/grid_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

using Eigen::ArrayXd;
using Eigen::Vector2d;

/// Below this the rounding of heights would be taken for shape.
constexpr double kFinest_mm = 1e-6;
/// Stretches between two borders: an end to what numbers beyond reason could ask for.
constexpr double kMaxStretches = 4096;
/// Cuts are found by halving, to 1e-12 of a stretch. This is more than that costs in height, so
/// that a contour of exactly n stretches does not get a sliver as its last.
constexpr int kHalvings = 40;
constexpr double kSlack = 1 + 1e-9;

/// The distinct coordinates, rising; each is the lowest of those that count as the same.
std::vector<double> distinct(std::vector<double> values_mm) {
  std::ranges::sort(values_mm);
  std::vector<double> kept;
  for (const double v_mm : values_mm) {
    if (kept.empty() || v_mm - kept.back() > GridMap::kSamePlace.in_mm()) kept.push_back(v_mm);
  }
  return kept;
}

/// Index of the distinct coordinate that a value belongs to.
std::size_t index_of(std::span<const double> coordinates_mm, double v_mm) {
  const auto behind = std::ranges::upper_bound(coordinates_mm, v_mm);
  return static_cast<std::size_t>(behind - coordinates_mm.begin()) - 1;
}

/// The cell between two neighbouring coordinates, the first or the last one for values outside.
std::size_t cell_of(std::span<const double> coordinates_mm, double v_mm) {
  const auto inner = coordinates_mm.subspan(1, coordinates_mm.size() - 2);
  return static_cast<std::size_t>(std::ranges::upper_bound(inner, v_mm) - inner.begin());
}

std::optional<GridProblem> bad_point(std::span<const GridPoint> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const GridPoint& point = points[i];
    const std::size_t n_axes = points.front().heights.size();
    if (point.heights.empty() || point.heights.size() != n_axes) {
      return GridProblem{GridFailure::BadPoint,
                         fmt::format("a grid point has heights of {} Z axes; expected {}",
                                     point.heights.size(),
                                     std::max<std::size_t>(n_axes, 1)),
                         i};
    }
    const bool is_good = point.place_mm.allFinite() &&
                         std::ranges::all_of(point.heights, [](const HeightEstimate& estimate) {
                           return std::isfinite(estimate.height.in_mm()) &&
                                  std::isfinite(estimate.sigma.in_mm()) &&
                                  estimate.sigma >= Length();
                         });
    if (is_good) continue;
    return GridProblem{
        GridFailure::BadPoint,
        "a grid point has numbers that are not finite; expected finite ones and a sigma of "
        "0 or more",
        i};
  }
  return std::nullopt;
}

/// Appends the turns, as fractions of the sweep, that bring an arc from its start to an angle.
void add_turns(double angle_rad, double start_rad, double sweep_rad, std::vector<double>& knots) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const double ahead_rad = sweep_rad < 0 ? start_rad - angle_rad : angle_rad - start_rad;
  const double t = (ahead_rad - kTurn * std::floor(ahead_rad / kTurn)) / std::abs(sweep_rad);
  if (t > 0 && t < 1) knots.push_back(t);
}

}  // namespace

tl::expected<GridMap, GridProblem> GridMap::from_points(std::span<const GridPoint> points) {
  if (auto problem = bad_point(points)) return tl::unexpected(*std::move(problem));
  std::vector<double> x_mm, y_mm;
  for (const GridPoint& point : points) {
    x_mm.push_back(point.place_mm.x());
    y_mm.push_back(point.place_mm.y());
  }
  GridMap map;
  map.x_mm_ = distinct(std::move(x_mm));
  map.y_mm_ = distinct(std::move(y_mm));
  const std::size_t n_x = map.x_mm_.size();
  const std::size_t n_y = map.y_mm_.size();
  if (n_x < 2 || n_y < 2) {
    return tl::unexpected(GridProblem{
        GridFailure::TooFewPoints,
        fmt::format("the grid has {} columns and {} rows; expected at least 2 of both", n_x, n_y),
        std::nullopt});
  }

  std::vector<std::pair<std::size_t, std::size_t>> by_node;  // node, point
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector2d& p_mm = points[i].place_mm;
    by_node.emplace_back(index_of(map.y_mm_, p_mm.y()) * n_x + index_of(map.x_mm_, p_mm.x()), i);
  }
  std::ranges::sort(by_node);
  const auto place_of = [&](std::size_t i_node) {
    return fmt::format("({}, {}) mm", map.x_mm_[i_node % n_x], map.y_mm_[i_node / n_x]);
  };
  const auto twice = std::ranges::adjacent_find(by_node, {}, &decltype(by_node)::value_type::first);
  if (twice != by_node.end()) {
    return tl::unexpected(GridProblem{
        GridFailure::Duplicate,
        fmt::format("the grid has two points at {}; expected one", place_of(twice->first)),
        std::next(twice)->second});
  }
  for (std::size_t i = 0; i < n_x * n_y; ++i) {
    if (i < by_node.size() && by_node[i].first == i) continue;
    return tl::unexpected(GridProblem{
        GridFailure::Incomplete,
        fmt::format(
            "the grid has no point at {}; expected all {} x {} nodes", place_of(i), n_x, n_y),
        std::nullopt});
  }
  map.n_axes_ = points.front().heights.size();
  for (const auto& [node, i] : by_node) {
    map.nodes_.insert(map.nodes_.end(), points[i].heights.begin(), points[i].heights.end());
  }
  return map;
}

Vector2d GridMap::nearest_inside(const Vector2d& p_mm) const {
  return {std::clamp(p_mm.x(), x_mm_.front(), x_mm_.back()),
          std::clamp(p_mm.y(), y_mm_.front(), y_mm_.back())};
}

GridHeight GridMap::height_at(const Vector2d& p_mm) const {
  const Vector2d q_mm = nearest_inside(p_mm);
  const std::size_t ix = cell_of(x_mm_, q_mm.x());
  const std::size_t iy = cell_of(y_mm_, q_mm.y());
  const double u = (q_mm.x() - x_mm_[ix]) / (x_mm_[ix + 1] - x_mm_[ix]);
  const double v = (q_mm.y() - y_mm_[iy]) / (y_mm_[iy + 1] - y_mm_[iy]);
  const std::array<double, 4> weights = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
  GridHeight result;
  for (std::size_t axis = 0; axis < n_axes_; ++axis) {
    double height_mm = 0;
    double variance_mm2 = 0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      const HeightEstimate& corner = node(ix + k % 2, iy + k / 2, axis);
      height_mm += weights[k] * corner.height.in_mm();
      variance_mm2 += weights[k] * weights[k] * corner.sigma.in_mm() * corner.sigma.in_mm();
    }
    result.heights.push_back({mm(height_mm), mm(std::sqrt(variance_mm2))});
  }
  const Length outside = mm((p_mm - q_mm).norm());
  if (outside > kSamePlace) result.outside = outside;
  return result;
}

ArrayXd GridMap::heights_mm(const Vector2d& p_mm) const {
  const GridHeight found = height_at(p_mm);
  ArrayXd heights(static_cast<Eigen::Index>(n_axes_));
  for (std::size_t axis = 0; axis < n_axes_; ++axis) {
    heights[static_cast<Eigen::Index>(axis)] = found.heights[axis].height.in_mm();
  }
  return heights;
}

GridMap::CellForm GridMap::form_at(const Vector2d& p_mm,
                                   const Vector2d& about_mm,
                                   std::size_t axis) const {
  const Vector2d q_mm = nearest_inside(p_mm);
  const std::size_t ix = cell_of(x_mm_, q_mm.x());
  const std::size_t iy = cell_of(y_mm_, q_mm.y());
  const double width_mm = x_mm_[ix + 1] - x_mm_[ix];
  const double depth_mm = y_mm_[iy + 1] - y_mm_[iy];
  const auto z_mm = [&](std::size_t i, std::size_t k) {
    return node(ix + i, iy + k, axis).height.in_mm();
  };
  const double low = (z_mm(1, 0) - z_mm(0, 0)) / width_mm;
  const double high = (z_mm(1, 1) - z_mm(0, 1)) / width_mm;
  const double left = (z_mm(0, 1) - z_mm(0, 0)) / depth_mm;
  const double twist_per_mm = (high - low) / depth_mm;
  const bool x_holds = p_mm.x() != q_mm.x();
  const bool y_holds = p_mm.y() != q_mm.y();
  const double from_x_mm = (x_holds ? q_mm : about_mm).x() - x_mm_[ix];
  const double from_y_mm = (y_holds ? q_mm : about_mm).y() - y_mm_[iy];
  return {x_holds ? 0 : low + twist_per_mm * from_y_mm,
          y_holds ? 0 : left + twist_per_mm * from_x_mm,
          x_holds || y_holds ? 0 : twist_per_mm};
}

/// The heights along a contour. Between two knots they are smooth.
struct GridMap::Profile {
  std::vector<double> knots;                 // 0 ... 1
  std::vector<ArrayXd> at_knots_mm;          // by knot; by Z axis
  std::vector<std::vector<CellForm>> cells;  // by piece; by Z axis
  const BendOfCell& bend;

  /// True if the chord from (t0, h0) to (t1, h1), points of the profile, stays within the
  /// tolerance.
  bool is_close(
      double t0, const ArrayXd& h0_mm, double t1, const ArrayXd& h1_mm, double tolerance_mm) const {
    const auto gap_mm = [&](std::size_t k) -> ArrayXd {
      if (knots[k] <= t0 || knots[k] >= t1) return ArrayXd::Zero(h0_mm.size());
      const double share = (knots[k] - t0) / (t1 - t0);
      return at_knots_mm[k] - h0_mm - share * (h1_mm - h0_mm);
    };
    const auto behind = std::ranges::upper_bound(knots, t0);
    for (auto k = static_cast<std::size_t>(behind - knots.begin()); k < knots.size(); ++k) {
      const double begin = std::max(t0, knots[k - 1]);
      const double end = std::min(t1, knots[k]);
      const ArrayXd begin_mm = gap_mm(k - 1);
      const ArrayXd end_mm = gap_mm(k);
      for (Eigen::Index axis = 0; axis < begin_mm.size(); ++axis) {
        const Bend bends = bend(cells[k - 1][static_cast<std::size_t>(axis)], begin, end);
        const double above_mm = highest_mm(
            begin_mm[axis], end_mm[axis], -0.5 * (end - begin) * (end - begin) * bends.low_mm);
        const double below_mm = highest_mm(
            -begin_mm[axis], -end_mm[axis], 0.5 * (end - begin) * (end - begin) * bends.high_mm);
        if (!(std::max(above_mm, below_mm) <= tolerance_mm)) return false;
      }
      if (knots[k] >= t1) break;
    }
    return true;
  }

  /// Of begin + (end - begin) u + bow u (1 - u), 0 <= u <= 1.
  static double highest_mm(double begin_mm, double end_mm, double bow_mm) {
    const double rise_mm = end_mm - begin_mm;
    if (!(bow_mm > std::abs(rise_mm))) return std::max(begin_mm, end_mm);
    const double u = 0.5 * (1 + rise_mm / bow_mm);
    return begin_mm + bow_mm * u * u;
  }
};

std::vector<double> GridMap::split(std::vector<double> knots,
                                   const std::function<Vector2d(double)>& place_mm,
                                   const Vector2d& about_mm,
                                   const BendOfCell& bend,
                                   Length tolerance) const {
  knots.insert(knots.end(), {0.0, 1.0});
  std::ranges::sort(knots);
  knots.erase(std::unique(knots.begin(), knots.end()), knots.end());
  Profile profile{std::move(knots), {}, {}, bend};
  for (std::size_t k = 0; k < profile.knots.size(); ++k) {
    profile.at_knots_mm.push_back(heights_mm(place_mm(profile.knots[k])));
    if (k == 0) continue;
    const Vector2d middle_mm = place_mm(0.5 * (profile.knots[k - 1] + profile.knots[k]));
    std::vector<CellForm>& cell = profile.cells.emplace_back();
    for (std::size_t axis = 0; axis < n_axes_; ++axis) {
      cell.push_back(form_at(middle_mm, about_mm, axis));
    }
  }

  const double tolerance_mm = kSlack * std::max(kFinest_mm, tolerance.in_mm());
  std::vector<double> cuts;
  double t0 = 0;
  while (true) {
    const ArrayXd h0_mm = heights_mm(place_mm(t0));
    const auto reaches = [&](double t1, const ArrayXd& h1_mm) {
      return profile.is_close(t0, h0_mm, t1, h1_mm, tolerance_mm);
    };
    const auto behind = std::ranges::upper_bound(profile.knots, t0);
    auto k = static_cast<std::size_t>(behind - profile.knots.begin());
    while (k < profile.knots.size() && reaches(profile.knots[k], profile.at_knots_mm[k])) ++k;
    if (k == profile.knots.size()) return cuts;
    const double begin = profile.knots[k - 1];
    const double end = profile.knots[k];
    double low = std::max(t0, begin);
    double high = end;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      (reaches(middle, heights_mm(place_mm(middle))) ? low : high) = middle;
    }
    if (t0 >= begin) low = std::max(low, t0 + (end - begin) / kMaxStretches);
    // Pieces so short that their middle is one of their ends are not cut.
    t0 = low > t0 && low < end ? low : end;
    if (t0 == 1) return cuts;
    cuts.push_back(t0);
  }
}

/// The range of amplitude cos(w) between two angles in either order.
GridMap::Bend GridMap::bend_of_cosine(double amplitude_mm, double a_rad, double b_rad) {
  const auto [from_rad, to_rad] = std::minmax({a_rad, b_rad});
  const auto passes = [from = from_rad, to = to_rad](double angle_rad) {
    constexpr double kTurn = 2 * std::numbers::pi;
    return angle_rad + kTurn * std::ceil((from - angle_rad) / kTurn) <= to;
  };
  const auto [at_ends_low, at_ends_high] = std::minmax({std::cos(from_rad), std::cos(to_rad)});
  const double low_mm = amplitude_mm * (passes(std::numbers::pi) ? -1 : at_ends_low);
  const double high_mm = amplitude_mm * (passes(0) ? 1 : at_ends_high);
  return {std::min(low_mm, high_mm), std::max(low_mm, high_mm)};
}

std::vector<double> GridMap::split_line(const Vector2d& from_mm,
                                        const Vector2d& to_mm,
                                        Length tolerance) const {
  const Vector2d along_mm = to_mm - from_mm;
  if (!from_mm.allFinite() || !along_mm.allFinite()) return {};
  std::vector<double> knots;
  const auto add = [&](std::span<const double> borders_mm, double begin_mm, double length_mm) {
    for (const double border_mm : borders_mm) {
      // Without a component along the axis this is no number, or infinite.
      const double t = (border_mm - begin_mm) / length_mm;
      if (t > 0 && t < 1) knots.push_back(t);
    }
  };
  add(x_mm_, from_mm.x(), along_mm.x());
  add(y_mm_, from_mm.y(), along_mm.y());
  return split(
      std::move(knots),
      [&](double t) -> Vector2d { return from_mm + t * along_mm; },
      from_mm,
      [&](const CellForm& cell, double /*t0*/, double /*t1*/) {
        const double bend_mm = 2 * cell.twist_per_mm * along_mm.x() * along_mm.y();
        return Bend{bend_mm, bend_mm};
      },
      tolerance);
}

std::vector<double> GridMap::split_arc(const Vector2d& center_mm,
                                       double start_angle_rad,
                                       double sweep_rad,
                                       double radius_mm,
                                       Length tolerance) const {
  const bool is_finite = center_mm.allFinite() && std::isfinite(start_angle_rad) &&
                         std::isfinite(sweep_rad) && std::isfinite(radius_mm);
  if (!is_finite || sweep_rad == 0 || !(radius_mm > 0)) return {};
  std::vector<double> knots;
  const auto add = [&](double angle_rad) {
    add_turns(angle_rad, start_angle_rad, sweep_rad, knots);
  };
  for (const double border_mm : x_mm_) {
    const double angle_rad = std::acos((border_mm - center_mm.x()) / radius_mm);
    add(angle_rad);
    add(-angle_rad);
  }
  for (const double border_mm : y_mm_) {
    const double angle_rad = std::asin((border_mm - center_mm.y()) / radius_mm);
    add(angle_rad);
    add(std::numbers::pi - angle_rad);
  }
  return split(
      std::move(knots),
      [&](double t) -> Vector2d {
        const double angle_rad = start_angle_rad + t * sweep_rad;
        return center_mm + radius_mm * Vector2d(std::cos(angle_rad), std::sin(angle_rad));
      },
      center_mm,
      [&](const CellForm& cell, double t0, double t1) {
        const double from_rad = start_angle_rad + t0 * sweep_rad;
        const double to_rad = start_angle_rad + t1 * sweep_rad;
        // -r (gx cos w + gy sin w) - 2 k r^2 sin 2w
        const Bend slope = bend_of_cosine(-radius_mm * std::hypot(cell.x, cell.y),
                                          from_rad - std::atan2(cell.y, cell.x),
                                          to_rad - std::atan2(cell.y, cell.x));
        const Bend twist = bend_of_cosine(-2 * cell.twist_per_mm * radius_mm * radius_mm,
                                          2 * from_rad - std::numbers::pi / 2,
                                          2 * to_rad - std::numbers::pi / 2);
        const double per_t = sweep_rad * sweep_rad;
        return Bend{per_t * (slope.low_mm + twist.low_mm), per_t * (slope.high_mm + twist.high_mm)};
      },
      tolerance);
}

}  // namespace panelcal
