// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/grid_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "calib/base/statistics/distributions.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kLeastNodes = 3;

double squared(double value) {
  return value * value;
}

/// Weights of up to four nodes along an axis, from the one before the cell to the one behind it.
struct Weights {
  std::size_t first = 0;
  std::array<double, 4> of = {};
  std::size_t n = 0;
};

Weights linear_weights(std::size_t cell, double u) {
  return {cell, {1 - u, u}, 2};
}

/// Of Hermite's cubic with the parabolas' slopes. Where these are limited a node weighs less.
Weights cubic_weights(std::span<const double> x, std::size_t cell, double u) {
  const double u2 = u * u, u3 = u2 * u;
  const double low = 2 * u3 - 3 * u2 + 1, high = 3 * u2 - 2 * u3;
  const double width = x[cell + 1] - x[cell];
  const double low_slope = width * (u3 - 2 * u2 + u), high_slope = width * (u3 - u2);
  Weights out;
  out.first = cell > 0 ? cell - 1 : 0;
  out.n = std::min(cell + 3, x.size()) - out.first;
  const auto add = [&](std::size_t i, double weight) { out.of[i - out.first] += weight; };
  add(cell, low);
  add(cell + 1, high);
  const auto add_slope = [&](std::size_t i, double weight) {
    const std::size_t before = i > 0 ? i - 1 : 0, behind = std::min(i + 1, x.size() - 1);
    const double by_step = weight / (x[behind] - x[before]);
    // At an end, the only difference: what the parabola adds is limited anyway.
    if (before == i || behind == i) {
      add(behind, by_step);
      add(before, -by_step);
      return;
    }
    const double h0 = x[i] - x[before], h1 = x[behind] - x[i];
    add(behind, by_step * h0 / h1);
    add(i, by_step * (h1 / h0 - h0 / h1));
    add(before, -by_step * h1 / h0);
  };
  add_slope(cell, low_slope);
  add_slope(cell + 1, high_slope);
  return out;
}

}  // namespace

/// A cell of the grid and where a place is in it.
struct GridSurface::Cell {
  std::size_t i, j;
  double width_mm, height_mm;
  double u, v;  // 0 to 1
};

Expected<GridSurface> GridSurface::of(std::span<const ProbePoint> points, bool is_bicubic) {
  std::vector<GridPoint> grid;
  for (const ProbePoint& point : points) {
    grid.push_back({point.place.in_mm(), {point.measured}});
  }
  auto map = GridMap::from_points(grid);
  if (!map) {
    const Place from = map.error().i_point ? points[*map.error().i_point].from
                       : points.empty()    ? Place()
                                           : points.front().from;
    return failure({Code::GridInvalid, from, std::move(map.error().text), ""});
  }
  GridSurface out(*std::move(map));
  const std::size_t n_x = out.map_.columns_mm().size(), n_y = out.map_.rows_mm().size();
  if (n_x < kLeastNodes || n_y < kLeastNodes) {
    return failure({Code::GridInvalid,
                    points.front().from,
                    fmt::format("a grid of {} x {} probes", n_x, n_y),
                    "3 or more each way, so that probes left out show the error between them"});
  }
  out.is_bicubic_ = is_bicubic;
  out.learn();
  return out;
}

void GridSurface::learn() {
  const std::span<const double> x = map_.columns_mm(), y = map_.rows_mm();
  std::vector<double> heights_mm;
  for (const double y_mm : y) {
    for (const double x_mm : x) {
      const HeightEstimate at_node = map_.height_at({x_mm, y_mm}).heights.front();
      heights_mm.push_back(at_node.height.in_mm());
      sigmas_mm_.push_back(at_node.sigma.in_mm());
    }
  }
  nodes_ = monotone_nodes(x, y, heights_mm);
  double slopes = 0;
  std::size_t n_slopes = 0;
  for (const int axis : {0, 1}) {
    double curvatures = 0, scatter = 0, n = 0;
    for (std::size_t j = 0; j < y.size(); ++j) {
      for (std::size_t i = 0; i < x.size(); ++i) {
        const std::size_t k = axis == 0 ? i : j, n_k = axis == 0 ? x.size() : y.size();
        const MonotoneNode& here = nodes_[j * x.size() + i];
        if (k + 1 < n_k) {
          const MonotoneNode& next = axis == 0 ? (&here)[1] : (&here)[x.size()];
          const double step_mm = axis == 0 ? x[i + 1] - x[i] : y[j + 1] - y[j];
          slopes += squared((next.height - here.height) / step_mm);
          ++n_slopes;
        }
        if (k == 0 || k + 1 == n_k) continue;
        const Prediction others = predicted(i, j, axis);
        const double sigma_mm = node(i, j).sigma.in_mm();
        const double by_product = 1 / squared(others.product_mm2);
        curvatures += squared(here.height - others.height_mm) * by_product;
        scatter += (squared(sigma_mm) + others.variance_mm2) * by_product;
        n += 1;
      }
    }
    const double bent = std::max(0.0, curvatures - scatter) + scatter * std::sqrt(2 / n);
    curvature_per_mm_[axis] = std::sqrt(bent / n);
  }
  slope_ = std::sqrt(slopes / static_cast<double>(n_slopes));
  double together = 0, n_inner = 0;
  for (std::size_t j = 1; j + 1 < y.size(); ++j) {
    for (std::size_t i = 1; i + 1 < x.size(); ++i, ++n_inner) {
      const Prediction along_x = predicted(i, j, 0), along_y = predicted(i, j, 1);
      const HeightEstimate here = node(i, j);
      const double product =
          (here.height.in_mm() - along_x.height_mm) * (here.height.in_mm() - along_y.height_mm);
      // The node's own scatter is in both.
      together +=
          (product - squared(here.sigma.in_mm())) / (along_x.product_mm2 * along_y.product_mm2);
    }
  }
  const double most = curvature_per_mm_.prod();
  curvatures_together_ = std::clamp(together / n_inner, -most, most);
}

double GridSurface::missed_variance_mm2(double x_product_mm2, double y_product_mm2) const {
  const double along_x_mm = curvature_per_mm_.x() * x_product_mm2;
  const double along_y_mm = curvature_per_mm_.y() * y_product_mm2;
  return squared(along_x_mm) + squared(along_y_mm) +
         2 * curvatures_together_ * x_product_mm2 * y_product_mm2;
}

GridSurface::Prediction GridSurface::predicted(std::size_t i, std::size_t j, int axis) const {
  const std::span<const double> all = axis == 0 ? map_.columns_mm() : map_.rows_mm();
  const std::size_t k = axis == 0 ? i : j;
  const auto others_node = [&](std::size_t m) { return axis == 0 ? node(m, j) : node(i, m); };
  const double width_mm = all[k + 1] - all[k - 1];
  const double u = (all[k] - all[k - 1]) / width_mm;
  const HeightEstimate before = others_node(k - 1), behind = others_node(k + 1);
  Prediction out;
  out.height_mm = (1 - u) * before.height.in_mm() + u * behind.height.in_mm();
  out.variance_mm2 = squared((1 - u) * before.sigma.in_mm()) + squared(u * behind.sigma.in_mm());
  out.product_mm2 = u * (1 - u) * squared(width_mm);
  if (!is_bicubic_) return out;
  // The row as it would be without the node.
  std::vector<double> places_mm, heights_mm;
  for (std::size_t m = 0; m < all.size(); ++m) {
    if (m == k) continue;
    places_mm.push_back(all[m]);
    heights_mm.push_back(others_node(m).height.in_mm());
  }
  out.height_mm = cubic_at(hermite(heights_mm[k - 1],
                                   width_mm * monotone_slope(places_mm, heights_mm, k - 1),
                                   heights_mm[k],
                                   width_mm * monotone_slope(places_mm, heights_mm, k)),
                           u);
  return out;
}

GridSurface::Prediction GridSurface::predicted_corner(std::size_t i, std::size_t j) const {
  const std::size_t k = i == 0 ? 1 : i - 1, l = j == 0 ? 1 : j - 1;
  const HeightEstimate beside = node(k, j), below = node(i, l), across = node(k, l);
  return {
      (beside.height + below.height - across.height).in_mm(),
      squared(beside.sigma.in_mm()) + squared(below.sigma.in_mm()) + squared(across.sigma.in_mm()),
      0};
}

std::vector<LeftOutProbe> GridSurface::left_out(std::span<const ProbePoint> points) const {
  const std::span<const double> x = map_.columns_mm(), y = map_.rows_mm();
  const auto index_of = [](std::span<const double> all, double value) {
    return static_cast<std::size_t>(
        std::ranges::min_element(all, {}, [&](double other) { return std::abs(other - value); }) -
        all.begin());
  };
  std::vector<LeftOutProbe> out;
  for (const ProbePoint& point : points) {
    const std::size_t i = index_of(x, point.place.in_mm().x());
    const std::size_t j = index_of(y, point.place.in_mm().y());
    const bool is_between[2] = {i > 0 && i + 1 < x.size(), j > 0 && j + 1 < y.size()};
    double height_mm = 0, variance_mm2 = 0, missed_mm = 0;
    const double share = is_between[0] && is_between[1] ? 0.5 : 1;
    for (const int axis : {0, 1}) {
      if (!is_between[axis]) continue;
      const Prediction others = predicted(i, j, axis);
      height_mm += share * others.height_mm;
      variance_mm2 += squared(share) * others.variance_mm2;
      missed_mm += share * curvature_per_mm_[axis] * others.product_mm2;
    }
    if (!is_between[0] && !is_between[1]) {
      const Prediction others = predicted_corner(i, j);
      height_mm = others.height_mm;
      variance_mm2 = others.variance_mm2;
      const double width_mm = i == 0 ? x[1] - x[0] : x[i] - x[i - 1];
      const double side_mm = j == 0 ? y[1] - y[0] : y[j] - y[j - 1];
      missed_mm = curvature_per_mm_.maxCoeff() * 2 * width_mm * side_mm;
    }
    const double sigma_mm =
        std::sqrt(variance_mm2 + squared(missed_mm) + squared(point.measured.sigma.in_mm()));
    LeftOutProbe probe;
    probe.deviation = point.measured.height - mm(height_mm);
    probe.sigma = mm(sigma_mm);
    probe.chance = 2 * normal_exceedance(std::abs(*probe.deviation / probe.sigma));
    out.push_back(probe);
  }
  return out;
}

GridSurface::Cell GridSurface::cell_of(const Vector2d& inside_mm) const {
  const auto cell = [](std::span<const double> all, double value) {
    const auto inner = all.subspan(1, all.size() - 2);
    return static_cast<std::size_t>(std::ranges::upper_bound(inner, value) - inner.begin());
  };
  const std::span<const double> x = map_.columns_mm(), y = map_.rows_mm();
  Cell out;
  out.i = cell(x, inside_mm.x());
  out.j = cell(y, inside_mm.y());
  out.width_mm = x[out.i + 1] - x[out.i];
  out.height_mm = y[out.j + 1] - y[out.j];
  out.u = (inside_mm.x() - x[out.i]) / out.width_mm;
  out.v = (inside_mm.y() - y[out.j]) / out.height_mm;
  return out;
}

HeightEstimate GridSurface::at(const Vector2d& p_mm) const {
  const std::span<const double> x = map_.columns_mm(), y = map_.rows_mm();
  const Vector2d inside_mm(std::clamp(p_mm.x(), x.front(), x.back()),
                           std::clamp(p_mm.y(), y.front(), y.back()));
  const Cell cell = cell_of(inside_mm);
  const MonotoneNode* low = &nodes_[cell.j * x.size() + cell.i];
  const MonotoneNode* high = low + x.size();
  double height_mm = 0;
  if (is_bicubic_) {
    const Eigen::Array44d c =
        bicubic_cell(low[0], low[1], high[0], high[1], cell.width_mm, cell.height_mm);
    Eigen::Array4d by_v;
    for (Eigen::Index k = 0; k < 4; ++k) by_v[k] = cubic_at(c.col(k), cell.u);
    height_mm = cubic_at(by_v, cell.v);
  } else {
    height_mm = (1 - cell.v) * ((1 - cell.u) * low[0].height + cell.u * low[1].height) +
                cell.v * ((1 - cell.u) * high[0].height + cell.u * high[1].height);
  }
  const Weights by_x =
      is_bicubic_ ? cubic_weights(x, cell.i, cell.u) : linear_weights(cell.i, cell.u);
  const Weights by_y =
      is_bicubic_ ? cubic_weights(y, cell.j, cell.v) : linear_weights(cell.j, cell.v);
  double variance_mm2 = 0;
  for (std::size_t l = 0; l < by_y.n; ++l) {
    for (std::size_t k = 0; k < by_x.n; ++k) {
      const double sigma_mm = node(by_x.first + k, by_y.first + l).sigma.in_mm();
      variance_mm2 += squared(by_x.of[k] * by_y.of[l] * sigma_mm);
    }
  }
  const double missed_mm2 = missed_variance_mm2(squared(cell.width_mm) * cell.u * (1 - cell.u),
                                                squared(cell.height_mm) * cell.v * (1 - cell.v));
  const double outside_mm = slope_ * (p_mm - inside_mm).norm();
  return {mm(height_mm), mm(std::sqrt(variance_mm2 + missed_mm2 + squared(outside_mm)))};
}

Length GridSurface::usually_missed() const {
  const auto widest = [](std::span<const double> all) {
    double out = 0;
    for (std::size_t k = 1; k < all.size(); ++k) out = std::max(out, all[k] - all[k - 1]);
    return out;
  };
  return mm(std::sqrt(missed_variance_mm2(0.25 * squared(widest(map_.columns_mm())),
                                          0.25 * squared(widest(map_.rows_mm())))));
}

}  // namespace panelcal::internal
