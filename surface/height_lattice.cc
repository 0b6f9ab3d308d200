// SPDX-License-Identifier: Apache-2.0
#include "panelcal/surface/height_lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "panelcal/surface/monotone_nodes.h"

namespace panelcal {
namespace {

/// In steps: a place that lies outside by rounding is inside.
constexpr double kSameNode = 1e-11;

/// Coordinates of nodes in steps.
std::vector<double> counted(int n_nodes) {
  std::vector<double> out;
  for (int i = 0; i < n_nodes; ++i) out.push_back(i);
  return out;
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
  const std::vector<internal::MonotoneNode> nodes =
      internal::monotone_nodes(counted(x_.n_nodes), counted(y_.n_nodes), heights_mm);
  const std::size_t n_x = n_columns_ + 1;
  for (std::size_t j = 0; j < n_rows_; ++j) {
    for (std::size_t i = 0; i < n_columns_; ++i) {
      const internal::MonotoneNode* node = &nodes[j * n_x + i];
      const Eigen::Array44d cell =
          internal::bicubic_cell(node[0], node[1], node[n_x], node[n_x + 1], 1, 1);
      for (Eigen::Index k = 0; k < 4; ++k) bicubic_.emplace_back(cell.col(k));
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
