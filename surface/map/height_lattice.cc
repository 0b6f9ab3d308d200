// SPDX-License-Identifier: Apache-2.0
#include "surface/map/height_lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "surface/fit/monotone_nodes.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Coordinates of nodes in steps.
std::vector<double> counted(int n_nodes) {
  std::vector<double> out;
  for (int i = 0; i < n_nodes; ++i) out.push_back(i);
  return out;
}

/// Weights at t of heights and slopes at 0 and 1.
struct HermiteWeights {
  double low, low_slope, high, high_slope;

  explicit HermiteWeights(double t) {
    const double rest = 1 - t;
    high = t * t * (3 - 2 * t);
    low = 1 - high;
    low_slope = t * rest * rest;
    high_slope = -t * t * rest;
  }
};

Expected<void> check_axis(const LatticeAxis& axis, const char* name) {
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
  PANELCAL_CHECK(check_axis(x, "x"));
  PANELCAL_CHECK(check_axis(y, "y"));
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
        {Code::GridInvalid, {}, "a height of the lattice is not finite", "finite numbers"});
  }
  return HeightLattice(x, y, heights_mm, interpolation);
}

HeightLattice::HeightLattice(const LatticeAxis& x,
                             const LatticeAxis& y,
                             std::span<const double> heights_mm,
                             LatticeInterpolation interpolation)
    : x_(x),
      y_(y),
      n_columns_(static_cast<std::size_t>(x.n_nodes - 1)),
      n_rows_(static_cast<std::size_t>(y.n_nodes - 1)),
      finder_{x.first_mm,
              y.first_mm,
              1 / x.step_mm,
              1 / y.step_mm,
              std::nextafter(x.n_nodes - 1, 0),
              std::nextafter(y.n_nodes - 1, 0),
              n_columns_} {
  if (interpolation == LatticeInterpolation::Bilinear) {
    nodes_mm_.assign(heights_mm.begin(), heights_mm.end());
  } else {
    set_bicubic(heights_mm);
  }
}

void HeightLattice::set_bicubic(std::span<const double> heights_mm) {
  for (const internal::MonotoneNode& node :
       internal::monotone_nodes(counted(x_.n_nodes), counted(y_.n_nodes), heights_mm)) {
    heights_mm_.insert(heights_mm_.end(), {node.height, node.by_x});
    slopes_mm_.insert(slopes_mm_.end(), {node.by_y, node.twist});
  }
}

inline HeightLattice::Local HeightLattice::Finder::local(const Eigen::Vector2d& p_mm) const {
  const double x = (p_mm.x() - first_x_mm) * cells_per_x_mm;
  const double y = (p_mm.y() - first_y_mm) * cells_per_y_mm;
  // In this order what is no number becomes 0. The last node counts as the end of the last cell.
  // By hand, since std::min's references go through memory.
  const double x_low = x > 0 ? x : 0, y_low = y > 0 ? y : 0;
  const double x_inside = x_low < below_n_columns ? x_low : below_n_columns;
  const double y_inside = y_low < below_n_rows ? y_low : below_n_rows;
  const auto i = static_cast<int>(x_inside);
  const auto j = static_cast<int>(y_inside);
  const std::size_t cell = static_cast<std::size_t>(j) * n_columns + static_cast<std::size_t>(i);
  return {cell,
          cell + static_cast<std::size_t>(j),
          x_inside - i,
          y_inside - j,
          !(std::abs(x - x_inside) + std::abs(y - y_inside) <= kSameNode)};
}

/// Interpolation for a loop of its own: as Finder.
struct HeightLattice::Bilinear {
  const double* nodes_mm;
  std::size_t n_x;

  double operator()(const Local& at) const {
    const double* const low = nodes_mm + at.node;
    const double* const high = low + n_x;
    const double low_mm = low[0] + at.u * (low[1] - low[0]);
    const double high_mm = high[0] + at.u * (high[1] - high[0]);
    return low_mm + at.v * (high_mm - low_mm);
  }
};

/// Along y the two columns together, (height, slope, height, slope) at once; then along x.
struct HeightLattice::Bicubic {
  const double* heights_mm;
  const double* slopes_mm;
  std::size_t n_x;

  double operator()(const Local& at) const {
    using FourOf = Eigen::Map<const Eigen::Array4d>;
    const std::size_t low = 2 * at.node, high = low + 2 * n_x;
    const HermiteWeights y(at.v), x(at.u);
    const Eigen::Array4d columns =
        (y.low * FourOf(heights_mm + low) + y.low_slope * FourOf(slopes_mm + low)) +
        (y.high * FourOf(heights_mm + high) + y.high_slope * FourOf(slopes_mm + high));
    return (x.low * columns[0] + x.low_slope * columns[1]) +
           (x.high * columns[2] + x.high_slope * columns[3]);
  }
};

inline HeightLattice::Bilinear HeightLattice::bilinear() const {
  return {nodes_mm_.data(), n_columns_ + 1};
}

inline HeightLattice::Bicubic HeightLattice::bicubic() const {
  return {heights_mm_.data(), slopes_mm_.data(), n_columns_ + 1};
}

std::size_t HeightLattice::cell_of(const Eigen::Vector2d& p_mm) const {
  return finder_.local(p_mm).cell;
}

bool HeightLattice::is_inside(const Eigen::Vector2d& p_mm) const {
  return !finder_.local(p_mm).is_outside;
}

double HeightLattice::height_mm(const Eigen::Vector2d& p_mm) const {
  const Local at = finder_.local(p_mm);
  return heights_mm_.empty() ? bilinear()(at) : bicubic()(at);
}

bool HeightLattice::heights_mm(std::span<const Eigen::Vector2d> places_mm,
                               std::span<double> heights_mm,
                               std::span<const std::uint8_t> cell_marks) const {
  const std::size_t n = std::min(places_mm.size(), heights_mm.size());
  const bool has_marks = cell_marks.size() == n_cells();
  bool is_due = places_mm.size() != heights_mm.size() || has_marks == cell_marks.empty();
  const std::size_t n_taken = heights_in_fours(
      places_mm.first(n), heights_mm.data(), has_marks ? cell_marks.data() : nullptr, is_due);
  const auto others = [&](const auto height, const auto mark) {
    const Finder finder = finder_;
    unsigned marks = is_due ? 1 : 0;
    for (std::size_t k = n_taken; k < n; ++k) {
      const Local at = finder.local(places_mm[k]);
      heights_mm[k] = height(at);
      marks |= static_cast<unsigned>(at.is_outside) | mark(at);
    }
    return marks != 0;
  };
  const auto mark = [marks = cell_marks.data()](const Local& at) {
    return static_cast<unsigned>(marks[at.cell]);
  };
  const auto none = [](const Local&) { return 0U; };
  if (heights_mm_.empty()) return has_marks ? others(bilinear(), mark) : others(bilinear(), none);
  return has_marks ? others(bicubic(), mark) : others(bicubic(), none);
}

}  // namespace panelcal
