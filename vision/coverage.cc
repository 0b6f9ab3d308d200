// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/coverage.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace panelcal::internal {
namespace {

/// Beyond this many sigmas of the lens blur, plus half a pixel, a pixel's weight is below 1e-9.
constexpr double kReachSigmas = 6;

double normal_cdf(double t) {
  return 0.5 * std::erfc(-t * std::numbers::sqrt2 / 2);
}

/// Integral of normal_cdf.
double normal_cdf_integral(double t) {
  return t * normal_cdf(t) + std::exp(-0.5 * t * t) / std::sqrt(2 * std::numbers::pi);
}

/// A pixel's sensitivity along one axis, at distance x from its centre: box * Gauss.
double pixel_weight(double x, double blur_px) {
  return normal_cdf((x + 0.5) / blur_px) - normal_cdf((x - 0.5) / blur_px);
}

double pixel_weight_integral(double x, double blur_px) {
  return blur_px *
         (normal_cdf_integral((x + 0.5) / blur_px) - normal_cdf_integral((x - 0.5) / blur_px));
}

/// The pixels an outline can reach, inside the picture.
ShareMap make_box(std::span<const OutlineNode> nodes, double reach, int width, int height) {
  Eigen::Vector2d low = nodes.front().at_px;
  Eigen::Vector2d high = low;
  for (const OutlineNode& node : nodes) {
    low = low.cwiseMin(node.at_px);
    high = high.cwiseMax(node.at_px);
  }
  // Clamped as doubles: an outline far outside must not overflow an int.
  const auto clamped = [](double v, int end) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(end)));
  };
  ShareMap map;
  map.x0 = clamped(std::ceil(low.x() - reach), width);
  map.y0 = clamped(std::ceil(low.y() - reach), height);
  map.width = std::max(0, clamped(std::floor(high.x() + reach) + 1, width) - map.x0);
  map.height = std::max(0, clamped(std::floor(high.y() + reach) + 1, height) - map.y0);
  map.share.assign(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height), 0);
  return map;
}

/// Pixels well to the left of a node see G = 1: `full` holds these parts by their last column, to
/// be summed from the right.
void add_node(const OutlineNode& node,
              double blur_px,
              double reach,
              ShareMap& map,
              std::vector<double>& full,
              std::vector<double>& column_weights) {
  const double x = node.at_px.x() - map.x0;
  const double y = node.at_px.y() - map.y0;
  if (!(x > -reach) || !(y > -reach) || !(y < map.height + reach)) return;
  const double last = map.width - 1.0;
  const int first_near = static_cast<int>(std::clamp(std::ceil(x - reach), 0.0, last + 1));
  const int end_near = static_cast<int>(std::clamp(std::floor(x + reach) + 1, 0.0, last + 1));
  column_weights.clear();
  for (int column = first_near; column < end_near; ++column) {
    column_weights.push_back(pixel_weight_integral(x - column, blur_px));
  }
  const int first_row = std::max(0, static_cast<int>(std::ceil(y - reach)));
  const int end_row = std::min(map.height, static_cast<int>(std::floor(y + reach)) + 1);
  for (int row = first_row; row < end_row; ++row) {
    const double weight = pixel_weight(y - row, blur_px) * node.dy_px;
    const std::size_t start = static_cast<std::size_t>(row) * static_cast<std::size_t>(map.width);
    for (int column = first_near; column < end_near; ++column) {
      map.share[start + static_cast<std::size_t>(column)] +=
          weight * column_weights[static_cast<std::size_t>(column - first_near)];
    }
    if (first_near > 0) full[start + static_cast<std::size_t>(first_near) - 1] += weight;
  }
}

}  // namespace

ShareMap share_inside(std::span<const OutlineNode> nodes, double blur_px, int width, int height) {
  if (nodes.empty()) return {};
  const double reach = 0.5 + kReachSigmas * blur_px;
  ShareMap map = make_box(nodes, reach, width, height);
  if (map.share.empty()) return {};

  std::vector<double> full(map.share.size(), 0);
  std::vector<double> column_weights;
  double area = 0;
  for (const OutlineNode& node : nodes) {
    area += node.at_px.x() * node.dy_px;
    add_node(node, blur_px, reach, map, full, column_weights);
  }
  const double sign = area < 0 ? -1 : 1;
  for (int row = 0; row < map.height; ++row) {
    double sum = 0;
    for (int column = map.width - 1; column >= 0; --column) {
      const std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(map.width) +
                            static_cast<std::size_t>(column);
      sum += full[i];
      map.share[i] = std::clamp(sign * (map.share[i] + sum), 0.0, 1.0);
    }
  }
  return map;
}

}  // namespace panelcal::internal
