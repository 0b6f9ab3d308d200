// SPDX-License-Identifier: Apache-2.0
#include "panelcal/surface/height_lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

/// Slopes larger than this share of a neighbouring difference could leave the range of the nodes
/// in the middle of a cell.
constexpr double kMostSlope = 1.5;

/// In steps: a place that lies outside by rounding is inside.
constexpr double kSameNode = 1e-11;

/// What Hermite's cell needs at a node, in units of a step.
struct Node {
  double height = 0;
  double by_x = 0;
  double by_y = 0;
  double twist = 0;
};

struct Nodes {
  int n_x;
  int n_y;
  std::vector<Node> all;

  Node& at(int i, int j) { return all[static_cast<std::size_t>(j * n_x + i)]; }
  const Node& at(int i, int j) const { return all[static_cast<std::size_t>(j * n_x + i)]; }
};

/// The slope at a node from the differences before and behind it.
double monotone_slope(double before, double behind) {
  if (!(before * behind > 0)) return 0;
  const double most = kMostSlope * std::min(std::abs(before), std::abs(behind));
  return std::clamp(0.5 * (before + behind), -most, most);
}

/// At node i of n: at an end the parabola through three nodes, limited by the only difference.
template <class Value>
double slope_at(int i, int n, const Value& value) {
  const auto difference = [&](int k) { return value(k + 1) - value(k); };
  if (n == 2) return difference(0);
  if (i > 0 && i < n - 1) return monotone_slope(difference(i - 1), difference(i));
  const double beside = i == 0 ? difference(0) : difference(n - 2);
  const double next = i == 0 ? difference(1) : difference(n - 3);
  const double parabola = beside + 0.5 * (beside - next);
  if (!(parabola * beside > 0)) return 0;
  const double most = kMostSlope * std::abs(beside);
  return std::clamp(parabola, -most, most);
}

/// Cuts a twist to what keeps the control point of the node (i, j) in the cell beyond it, sign_x
/// and sign_y away, within the range of the cell's nodes.
void limit_twist(
    const Nodes& nodes, int i, int j, int sign_x, int sign_y, double& low, double& high) {
  const int k = i + sign_x, l = j + sign_y;
  if (k < 0 || k >= nodes.n_x || l < 0 || l >= nodes.n_y) return;
  const Node& node = nodes.at(i, j);
  const auto [least, most] = std::minmax(
      {node.height, nodes.at(k, j).height, nodes.at(i, l).height, nodes.at(k, l).height});
  const double untwisted = node.height + (sign_x * node.by_x + sign_y * node.by_y) / 3;
  double down = std::min(0.0, 9 * (least - untwisted));
  double up = std::max(0.0, 9 * (most - untwisted));
  if (sign_x * sign_y < 0) {
    std::swap(down, up);
    down = -down;
    up = -up;
  }
  low = std::max(low, down);
  high = std::min(high, up);
}

Nodes nodes_of(int n_x, int n_y, std::span<const double> heights_mm) {
  Nodes nodes{n_x, n_y, std::vector<Node>(heights_mm.size())};
  for (std::size_t i = 0; i < heights_mm.size(); ++i) nodes.all[i].height = heights_mm[i];
  for (int j = 0; j < n_y; ++j) {
    for (int i = 0; i < n_x; ++i) {
      Node& node = nodes.at(i, j);
      node.by_x = slope_at(i, n_x, [&](int k) { return nodes.at(k, j).height; });
      node.by_y = slope_at(j, n_y, [&](int k) { return nodes.at(i, k).height; });
    }
  }
  for (int j = 0; j < n_y; ++j) {
    for (int i = 0; i < n_x; ++i) {
      const int before = std::max(0, i - 1), behind = std::min(n_x - 1, i + 1);
      const int below = std::max(0, j - 1), above = std::min(n_y - 1, j + 1);
      const double mixed = nodes.at(behind, above).height - nodes.at(behind, below).height -
                           nodes.at(before, above).height + nodes.at(before, below).height;
      const double twist = mixed / ((behind - before) * (above - below));
      double low = std::min(0.0, twist), high = std::max(0.0, twist);
      for (const int sign_x : {-1, 1}) {
        for (const int sign_y : {-1, 1}) limit_twist(nodes, i, j, sign_x, sign_y, low, high);
      }
      nodes.at(i, j).twist = std::clamp(twist, low, high);
    }
  }
  return nodes;
}

/// Coefficients of 1, t, t^2, t^3 from the height and the slope at t = 0 and at t = 1.
Eigen::Array4d cubic(double h0, double s0, double h1, double s1) {
  return {h0, s0, 3 * (h1 - h0) - 2 * s0 - s1, 2 * (h0 - h1) + s0 + s1};
}

Expected<void> check(const LatticeAxis& axis, const char* name) {
  const auto bad = [&](std::string what, const char* expected) {
    return failure(
        {Code::GridInvalid, {}, fmt::format("a lattice {} along {}", what, name), expected});
  };
  if (axis.n_nodes < 2) return bad(fmt::format("of {} nodes", axis.n_nodes), "2 or more");
  if (!std::isnormal(axis.step_mm) || !(axis.step_mm > 0)) {
    return bad(fmt::format("with a step of {} mm", axis.step_mm), "above 0 mm");
  }
  if (!std::isfinite(axis.first_mm) || !std::isfinite(axis.last_mm())) {
    return bad(fmt::format("from {} to {} mm", axis.first_mm, axis.last_mm()), "finite numbers");
  }
  return {};
}

}  // namespace

Expected<HeightLattice> HeightLattice::make(const LatticeAxis& x,
                                            const LatticeAxis& y,
                                            std::span<const double> heights_mm,
                                            LatticeInterpolation interpolation) {
  PANELCAL_CHECK(check(x, "x"));
  PANELCAL_CHECK(check(y, "y"));
  const auto n_columns = static_cast<std::size_t>(x.n_nodes);
  const auto n_rows = static_cast<std::size_t>(y.n_nodes);
  // Nodes and cells are counted with int.
  constexpr auto kMostNodes = static_cast<std::size_t>(std::numeric_limits<int>::max());
  if (n_columns > kMostNodes / n_rows || heights_mm.size() != n_columns * n_rows) {
    return failure(
        {Code::GridInvalid,
         {},
         fmt::format("{} heights for {} x {} nodes", heights_mm.size(), n_columns, n_rows),
         "one for each node"});
  }
  if (!std::ranges::all_of(heights_mm, [](double h_mm) { return std::isfinite(h_mm); })) {
    return failure(
        {Code::GridInvalid, {}, "a lattice with a height that is none", "finite numbers"});
  }
  return HeightLattice(x, y, heights_mm, interpolation);
}

HeightLattice::HeightLattice(const LatticeAxis& x,
                             const LatticeAxis& y,
                             std::span<const double> heights_mm,
                             LatticeInterpolation interpolation)
    : x_(x),
      y_(y),
      cells_per_x_mm_(1 / x.step_mm),
      cells_per_y_mm_(1 / y.step_mm),
      below_n_columns_(std::nextafter(x.n_nodes - 1, 0)),
      below_n_rows_(std::nextafter(y.n_nodes - 1, 0)),
      n_columns_(static_cast<std::size_t>(x.n_nodes - 1)),
      n_rows_(static_cast<std::size_t>(y.n_nodes - 1)) {
  if (interpolation == LatticeInterpolation::Bilinear) {
    set_bilinear(heights_mm);
  } else {
    set_bicubic(heights_mm);
  }
}

void HeightLattice::set_bilinear(std::span<const double> heights_mm) {
  const std::size_t n_x = n_columns_ + 1;
  for (std::size_t j = 0; j < n_rows_; ++j) {
    for (std::size_t i = 0; i < n_columns_; ++i) {
      const double* node = &heights_mm[j * n_x + i];
      bilinear_.push_back({node[0],
                           node[1] - node[0],
                           node[n_x] - node[0],
                           node[n_x + 1] - node[n_x] - node[1] + node[0]});
    }
  }
}

void HeightLattice::set_bicubic(std::span<const double> heights_mm) {
  const Nodes nodes = nodes_of(x_.n_nodes, y_.n_nodes, heights_mm);
  for (int j = 0; j + 1 < y_.n_nodes; ++j) {
    for (int i = 0; i + 1 < x_.n_nodes; ++i) {
      const Node& a = nodes.at(i, j);
      const Node& b = nodes.at(i + 1, j);
      const Node& c = nodes.at(i, j + 1);
      const Node& d = nodes.at(i + 1, j + 1);
      const Eigen::Array4d low = cubic(a.height, a.by_x, b.height, b.by_x);
      const Eigen::Array4d high = cubic(c.height, c.by_x, d.height, d.by_x);
      const Eigen::Array4d low_by_y = cubic(a.by_y, a.twist, b.by_y, b.twist);
      const Eigen::Array4d high_by_y = cubic(c.by_y, c.twist, d.by_y, d.twist);
      bicubic_.push_back(low);
      bicubic_.push_back(low_by_y);
      bicubic_.emplace_back(3 * (high - low) - 2 * low_by_y - high_by_y);
      bicubic_.emplace_back(2 * (low - high) + low_by_y + high_by_y);
    }
  }
}

inline HeightLattice::Local HeightLattice::local(const Eigen::Vector2d& p_mm) const {
  const double x = (p_mm.x() - x_.first_mm) * cells_per_x_mm_;
  const double y = (p_mm.y() - y_.first_mm) * cells_per_y_mm_;
  // In this order what is no number becomes 0. The last node counts as the end of the last cell.
  const double x_inside = std::min(x > 0 ? x : 0, below_n_columns_);
  const double y_inside = std::min(y > 0 ? y : 0, below_n_rows_);
  const auto i = static_cast<int>(x_inside);
  const auto j = static_cast<int>(y_inside);
  return {static_cast<std::size_t>(j * static_cast<int>(n_columns_) + i),
          x_inside - i,
          y_inside - j,
          !(std::abs(x - x_inside) <= kSameNode && std::abs(y - y_inside) <= kSameNode)};
}

inline double HeightLattice::bilinear_mm(const Local& at) const {
  const Bilinear& c = bilinear_[at.cell];
  return (c[0] + at.u * c[1]) + at.v * (c[2] + at.u * c[3]);
}

inline double HeightLattice::bicubic_mm(const Local& at) const {
  const Bicubic* c = &bicubic_[4 * at.cell];
  const double v2 = at.v * at.v;
  const Eigen::Array4d by_u = (c[0] + at.v * c[1]) + v2 * (c[2] + at.v * c[3]);
  return (by_u[0] + at.u * by_u[1]) + at.u * at.u * (by_u[2] + at.u * by_u[3]);
}

std::size_t HeightLattice::cell_of(const Eigen::Vector2d& p_mm) const {
  return local(p_mm).cell;
}

bool HeightLattice::is_inside(const Eigen::Vector2d& p_mm) const {
  return !local(p_mm).is_outside;
}

double HeightLattice::height_mm(const Eigen::Vector2d& p_mm) const {
  const Local at = local(p_mm);
  return bicubic_.empty() ? bilinear_mm(at) : bicubic_mm(at);
}

bool HeightLattice::heights_mm(std::span<const Eigen::Vector2d> places_mm,
                               std::span<double> heights_mm,
                               std::span<const std::uint8_t> cell_marks) const {
  const std::size_t n = std::min(places_mm.size(), heights_mm.size());
  const bool has_marks = cell_marks.size() == n_cells();
  const bool is_odd = places_mm.size() != heights_mm.size() || has_marks == cell_marks.empty();
  const auto all = [&](const auto& height, const auto& mark) {
    unsigned marks = is_odd ? 1 : 0;
    for (std::size_t k = 0; k < n; ++k) {
      const Local at = local(places_mm[k]);
      heights_mm[k] = height(at);
      marks |= static_cast<unsigned>(at.is_outside) | mark(at);
    }
    return marks != 0;
  };
  const auto bilinear = [&](const Local& at) { return bilinear_mm(at); };
  const auto bicubic = [&](const Local& at) { return bicubic_mm(at); };
  const auto mark = [&](const Local& at) { return static_cast<unsigned>(cell_marks[at.cell]); };
  const auto none = [](const Local&) { return 0U; };
  if (bicubic_.empty()) return has_marks ? all(bilinear, mark) : all(bilinear, none);
  return has_marks ? all(bicubic, mark) : all(bicubic, none);
}

}  // namespace panelcal
