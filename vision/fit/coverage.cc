// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/coverage.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace panelcal::internal {
namespace {

/// Beyond this many sigmas of the lens blur, plus half a pixel, a pixel's weight is below 1e-9.
constexpr double kReachSigmas = 6;
/// Table steps per sigma: the pieces' error is at most (1 / 32)^4 / 384 * 0.6.
constexpr double kStepsPerSigma = 32;
/// Less would take ever more nodes, more ever larger tables; no lens is like that.
constexpr double kLeastBlur_px = 0.2;
constexpr double kMostBlur_px = 1000;

double normal_density(double t) {
  return std::exp(-0.5 * t * t) / std::sqrt(2 * std::numbers::pi);
}

double normal_cdf(double t) {
  return 0.5 * std::erfc(-t * std::numbers::sqrt2 / 2);
}

/// Integral of normal_cdf.
double normal_cdf_integral(double t) {
  return t * normal_cdf(t) + normal_density(t);
}

/// The difference of f at both ends of a pixel at distance x.
template <class Function>
double across_pixel(Function f, double x, double blur_px) {
  return f((x + 0.5) / blur_px) - f((x - 0.5) / blur_px);
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

/// Adds node by node; pixels well to the left of one see G = 1, and are summed up at the end.
class Integrator {
 public:
  Integrator(ShareMap& map, const PixelResponse& response)
      : map_(map),
        response_(response),
        full_(map.share.size(), 0),
        columns_(static_cast<std::size_t>(2 * response.reach_px()) + 2),
        rows_(columns_.size()) {}

  void add(const OutlineNode& node) {
    const double reach = response_.reach_px();
    const double x = node.at_px.x() - map_.x0;
    const double y = node.at_px.y() - map_.y0;
    if (!(x > -reach) || !(y > -reach) || !(y < map_.height + reach)) return;
    const double end = map_.width;
    const int first_column = static_cast<int>(std::clamp(std::ceil(x - reach), 0.0, end));
    const int end_column = static_cast<int>(std::clamp(std::floor(x + reach) + 1, 0.0, end));
    const int first_row = std::max(0, static_cast<int>(std::ceil(y - reach)));
    const int end_row = std::min(map_.height, static_cast<int>(std::floor(y + reach)) + 1);
    if (end_row <= first_row) return;
    const auto n_rows = static_cast<std::size_t>(end_row - first_row);
    const auto n_columns = static_cast<std::size_t>(std::max(0, end_column - first_column));
    response_.integrals(x - first_column, std::span(columns_).first(n_columns));
    response_.weights(y - first_row, std::span(rows_).first(n_rows));
    std::size_t at = start_of(first_row) + static_cast<std::size_t>(first_column);
    for (std::size_t row = 0; row < n_rows; ++row, at += static_cast<std::size_t>(map_.width)) {
      const double weight = rows_[row] * node.dy_px;
      double* share = map_.share.data() + at;
      for (std::size_t column = 0; column < n_columns; ++column) {
        share[column] += weight * columns_[column];
      }
      if (first_column > 0) full_[at - 1] += weight;
    }
  }

  void finish() {
    for (int row = 0; row < map_.height; ++row) {
      double sum = 0;
      const std::size_t start = start_of(row);
      for (std::size_t i = start + static_cast<std::size_t>(map_.width); i-- > start;) {
        sum += full_[i];
        map_.share[i] += sum;
      }
    }
  }

 private:
  std::size_t start_of(int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(map_.width);
  }

  ShareMap& map_;
  const PixelResponse& response_;
  std::vector<double> full_;  ///< by the last column that sees all of a node
  std::vector<double> columns_;
  std::vector<double> rows_;
};

}  // namespace

PixelResponse::PixelResponse(double blur_px)
    : blur_px_(blur_px > kLeastBlur_px ? std::min(blur_px, kMostBlur_px) : kLeastBlur_px),
      reach_px_(0.5 + kReachSigmas * blur_px_),
      end_px_(std::ceil(reach_px_) + 1),
      steps_per_px_(static_cast<int>(std::ceil(kStepsPerSigma / blur_px_))) {
  const int n = 2 * static_cast<int>(end_px_) * steps_per_px_;
  const double step = 1.0 / steps_per_px_;
  const auto piece = [step](double v0, double slope0, double v1, double slope1) {
    const double a = slope0 * step;
    const double b = slope1 * step;
    return Cubic{v0, a, 3 * (v1 - v0) - 2 * a - b, 2 * (v0 - v1) + a + b};
  };
  struct Values {
    double slope, weight, integral;
  };
  const auto values_at = [sigma = blur_px_](double x) {
    return Values{across_pixel(normal_density, x, sigma) / sigma,
                  across_pixel(normal_cdf, x, sigma),
                  across_pixel(normal_cdf_integral, x, sigma) * sigma};
  };
  weight_.reserve(static_cast<std::size_t>(n));
  integral_.reserve(static_cast<std::size_t>(n));
  Values left = values_at(-end_px_);
  for (int i = 0; i < n; ++i) {
    const Values right = values_at(-end_px_ + (i + 1) * step);
    weight_.push_back(piece(left.weight, left.slope, right.weight, right.slope));
    integral_.push_back(piece(left.integral, left.weight, right.integral, right.weight));
    left = right;
  }
}

void PixelResponse::evaluate(const std::vector<Cubic>& table,
                             double first_px,
                             std::span<double> out) const {
  if (out.empty()) return;
  const double place = (first_px + end_px_) * steps_per_px_;
  auto i = static_cast<std::ptrdiff_t>(place);
  const double t = place - static_cast<double>(i);
  for (double& v : out) {
    const Cubic& c = table[static_cast<std::size_t>(i)];
    v = c.c0 + t * (c.c1 + t * (c.c2 + t * c.c3));
    i -= steps_per_px_;
  }
}

ShareMap integrate_inside(std::span<const OutlineNode> nodes,
                          const PixelResponse& response,
                          int width,
                          int height) {
  if (nodes.empty()) return {};
  ShareMap map = make_box(nodes, response.reach_px(), width, height);
  if (map.share.empty()) return {};
  Integrator integrator(map, response);
  for (const OutlineNode& node : nodes) integrator.add(node);
  integrator.finish();
  return map;
}

}  // namespace panelcal::internal
