// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/table_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/correction/spline_weights.h"

namespace panelcal {
namespace {

constexpr int kMaxMapSteps = 256;
/// A stage errs by a thousandth of its way at most, so each step is a thousand times shorter.
constexpr int kMaxMapIterations = 30;
constexpr double kConverged_mm = 1e-9;

}  // namespace

bool TableGrid::is_valid() const {
  const bool has_steps = nx >= 1 && ny >= 1 && nx <= kMaxMapSteps && ny <= kMaxMapSteps;
  const Eigen::Vector2d span_mm = high_mm - low_mm;
  return has_steps && low_mm.allFinite() && span_mm.allFinite() && span_mm.minCoeff() > 0;
}

TableMap::TableMap()
    : TableMap(TableGrid{}, std::vector<Eigen::Vector2d>(16, Eigen::Vector2d::Zero())) {
}

TableMap::TableMap(const TableGrid& grid, std::vector<Eigen::Vector2d> coefficients_mm)
    : grid_(grid),
      per_mm_(grid.step_mm().cwiseInverse()),
      coefficients_mm_(std::move(coefficients_mm)) {
}

bool TableMap::covers(const Position<frame::Machine>& commanded) const {
  const Eigen::Vector2d& c = commanded.in_mm();
  return (c.array() >= grid_.low_mm.array()).all() && (c.array() <= grid_.high_mm.array()).all();
}

Eigen::Vector2d TableMap::error_mm(const Position<frame::Machine>& commanded) const {
  const Eigen::Vector2d at = (commanded.in_mm() - grid_.low_mm).cwiseProduct(per_mm_);
  if (!at.allFinite()) return at * std::nan("");
  const internal::SplineWeights x(at.x(), grid_.nx);
  const internal::SplineWeights y(at.y(), grid_.ny);
  const Eigen::Vector2d* row =
      &coefficients_mm_[static_cast<std::size_t>(y.first * (grid_.nx + 3) + x.first)];
  double sum_x = 0;
  double sum_y = 0;
  for (std::size_t j = 0; j < 4; ++j, row += grid_.nx + 3) {
    double row_x = 0;
    double row_y = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      row_x += x.value[i] * row[i].x();
      row_y += x.value[i] * row[i].y();
    }
    sum_x += y.value[j] * row_x;
    sum_y += y.value[j] * row_y;
  }
  return {sum_x, sum_y};
}

Eigen::Matrix2d TableMap::error_slope(const Position<frame::Machine>& commanded) const {
  const Eigen::Vector2d at = (commanded.in_mm() - grid_.low_mm).cwiseProduct(per_mm_);
  if (!at.allFinite()) return Eigen::Matrix2d::Constant(std::nan(""));
  const internal::SplineWeights x(at.x(), grid_.nx);
  const internal::SplineWeights y(at.y(), grid_.ny);
  Eigen::Matrix2d slope = Eigen::Matrix2d::Zero();
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      const auto k = static_cast<std::size_t>((y.first + static_cast<int>(j)) * (grid_.nx + 3) +
                                              x.first + static_cast<int>(i));
      slope.col(0) += x.slope[i] * y.value[j] * per_mm_.x() * coefficients_mm_[k];
      slope.col(1) += x.value[i] * y.slope[j] * per_mm_.y() * coefficients_mm_[k];
    }
  }
  return slope;
}

std::optional<Position<frame::Machine>> TableMap::command_for(
    const Position<frame::Table>& wanted) const {
  Eigen::Vector2d c_mm = wanted.in_mm();
  if (!c_mm.allFinite()) return std::nullopt;
  for (int i = 0; i < kMaxMapIterations; ++i) {
    const Eigen::Vector2d next_mm = wanted.in_mm() - error_mm(position_mm<frame::Machine>(c_mm));
    const double step_mm = (next_mm - c_mm).norm();
    c_mm = next_mm;
    if (step_mm < kConverged_mm) return position_mm<frame::Machine>(c_mm);
  }
  return std::nullopt;
}

}  // namespace panelcal
