// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/monotone_nodes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace panelcal::internal {
namespace {

/// Slopes larger than this share of a neighbouring difference could leave the range of the nodes
/// in the middle of a cell.
constexpr double kMostSlope = 1.5;

struct Grid {
  std::span<const double> x, y;
  std::vector<MonotoneNode> nodes;

  MonotoneNode& at(std::size_t i, std::size_t j) { return nodes[j * x.size() + i]; }
  const MonotoneNode& at(std::size_t i, std::size_t j) const { return nodes[j * x.size() + i]; }
};

double limited(double slope, double most) {
  return std::clamp(slope, -kMostSlope * most, kMostSlope * most);
}

/// Limits of a twist.
struct Limits {
  double low, high;
};

/// Cuts a twist to what keeps the control point of the node (i, j) in the cell beyond it, sign_x
/// and sign_y away, within the range of the cell's nodes.
void limit_twist(
    const Grid& grid, std::size_t i, std::size_t j, int sign_x, int sign_y, Limits& twist) {
  const bool is_outside = (sign_x < 0 ? i == 0 : i + 1 == grid.x.size()) ||
                          (sign_y < 0 ? j == 0 : j + 1 == grid.y.size());
  if (is_outside) return;
  const std::size_t k = sign_x < 0 ? i - 1 : i + 1, l = sign_y < 0 ? j - 1 : j + 1;
  const double width = grid.x[k] - grid.x[i], height = grid.y[l] - grid.y[j];  // signed
  const MonotoneNode& node = grid.at(i, j);
  const auto [least, most] =
      std::minmax({node.height, grid.at(k, j).height, grid.at(i, l).height, grid.at(k, l).height});
  const double untwisted = node.height + (width * node.by_x + height * node.by_y) / 3;
  // Of the twist by the cell's size; then of the twist itself, whose sign the size may turn.
  const double down = 9 * std::min(0.0, least - untwisted) / (width * height);
  const double up = 9 * std::max(0.0, most - untwisted) / (width * height);
  twist.low = std::max(twist.low, std::min(down, up));
  twist.high = std::min(twist.high, std::max(down, up));
}

double twist_at(const Grid& grid, std::size_t i, std::size_t j) {
  const std::size_t before = i > 0 ? i - 1 : 0, behind = std::min(grid.x.size() - 1, i + 1);
  const std::size_t below = j > 0 ? j - 1 : 0, above = std::min(grid.y.size() - 1, j + 1);
  const double mixed = grid.at(behind, above).height - grid.at(behind, below).height -
                       grid.at(before, above).height + grid.at(before, below).height;
  const double twist =
      mixed / ((grid.x[behind] - grid.x[before]) * (grid.y[above] - grid.y[below]));
  Limits limits{std::min(0.0, twist), std::max(0.0, twist)};
  for (const int sign_x : {-1, 1}) {
    for (const int sign_y : {-1, 1}) limit_twist(grid, i, j, sign_x, sign_y, limits);
  }
  return std::clamp(twist, limits.low, limits.high);
}

}  // namespace

double monotone_slope(std::span<const double> x, std::span<const double> heights, std::size_t i) {
  const auto step = [&](std::size_t k) { return x[k + 1] - x[k]; };
  const auto slope = [&](std::size_t k) { return (heights[k + 1] - heights[k]) / step(k); };
  const std::size_t n = x.size();
  if (n == 2) return slope(0);
  if (i > 0 && i < n - 1) {
    const double before = slope(i - 1), behind = slope(i);
    if (!(before * behind > 0)) return 0;
    const double parabola = (step(i) * before + step(i - 1) * behind) / (step(i - 1) + step(i));
    return limited(parabola, std::min(std::abs(before), std::abs(behind)));
  }
  // At an end the parabola through three nodes, limited by the only difference.
  const std::size_t k = i == 0 ? 0 : n - 2, next = i == 0 ? 1 : n - 3;
  const double beside = slope(k);
  const double parabola = beside + (beside - slope(next)) * step(k) / (step(k) + step(next));
  if (!(parabola * beside > 0)) return 0;
  return limited(parabola, std::abs(beside));
}

std::vector<MonotoneNode> monotone_nodes(std::span<const double> x,
                                         std::span<const double> y,
                                         std::span<const double> heights) {
  Grid grid{x, y, std::vector<MonotoneNode>(heights.size())};
  for (std::size_t k = 0; k < heights.size(); ++k) grid.nodes[k].height = heights[k];
  for (std::size_t j = 0; j < y.size(); ++j) {
    const std::span<const double> row = heights.subspan(j * x.size(), x.size());
    for (std::size_t i = 0; i < x.size(); ++i) grid.at(i, j).by_x = monotone_slope(x, row, i);
  }
  std::vector<double> column(y.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t j = 0; j < y.size(); ++j) column[j] = grid.at(i, j).height;
    for (std::size_t j = 0; j < y.size(); ++j) grid.at(i, j).by_y = monotone_slope(y, column, j);
  }
  for (std::size_t j = 0; j < y.size(); ++j) {
    for (std::size_t i = 0; i < x.size(); ++i) grid.at(i, j).twist = twist_at(grid, i, j);
  }
  return std::move(grid.nodes);
}

Eigen::Array44d bicubic_cell(const MonotoneNode& low_left,
                             const MonotoneNode& low_right,
                             const MonotoneNode& high_left,
                             const MonotoneNode& high_right,
                             double width,
                             double height) {
  const auto along_x = [&](const MonotoneNode& a, const MonotoneNode& b) {
    return hermite(a.height, width * a.by_x, b.height, width * b.by_x);
  };
  const auto slope_along_x = [&](const MonotoneNode& a, const MonotoneNode& b) -> Eigen::Array4d {
    return height * hermite(a.by_y, width * a.twist, b.by_y, width * b.twist);
  };
  const Eigen::Array4d low = along_x(low_left, low_right);
  const Eigen::Array4d high = along_x(high_left, high_right);
  const Eigen::Array4d low_by_y = slope_along_x(low_left, low_right);
  const Eigen::Array4d high_by_y = slope_along_x(high_left, high_right);
  Eigen::Array44d out;
  out.col(0) = low;
  out.col(1) = low_by_y;
  out.col(2) = 3 * (high - low) - 2 * low_by_y - high_by_y;
  out.col(3) = 2 * (low - high) + low_by_y + high_by_y;
  return out;
}

}  // namespace panelcal::internal
