// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/base/calibration_plate.h"
#include "calib/base/frames.h"
#include <Eigen/Core>

namespace panelcal {

/// The rectangle of commanded places that a table map covers, in equal steps.
struct TableGrid {
  Eigen::Vector2d low_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d high_mm = Eigen::Vector2d::Ones();
  int nx = 1;  ///< steps along x
  int ny = 1;

  /// Of one coordinate of the error.
  int n_coefficients() const { return (nx + 3) * (ny + 3); }
  Eigen::Vector2d step_mm() const {
    return (high_mm - low_mm).cwiseQuotient(Eigen::Vector2d(nx, ny));
  }
  /// Finite, not empty, at least one step along each axis and at most 256.
  bool is_valid() const;
};

/// True position of a machine's stage: commanded place -> actual place.
///
///   actual = c + E(c),   E a bicubic B-spline on the grid, one coefficient (mm, mm) a knot
///
/// So scale, squareness, straightness and any smooth warp are one thing, and continuous to the
/// second derivative. Beyond the grid nothing was measured: there E is that of the nearest place of
/// the grid, and covers() says so.
///
/// Cost   30 ns a place, back 300 ns; neither allocates
/// Source de Boor 1978
/// See    tests/calib/correction/table_map_test.cc
class TableMap {
 public:
  /// No error anywhere.
  TableMap();
  /// Precondition: grid valid; coefficients finite, n_coefficients() of them, x fastest.
  TableMap(const TableGrid& grid, std::vector<Eigen::Vector2d> coefficients_mm);

  const TableGrid& grid() const { return grid_; }
  const std::vector<Eigen::Vector2d>& coefficients_mm() const { return coefficients_mm_; }

  bool covers(const Position<frame::Machine>& commanded) const;
  /// E; NaN for a place that is not finite.
  Eigen::Vector2d error_mm(const Position<frame::Machine>& commanded) const;
  /// dE/dc.
  Eigen::Matrix2d error_slope(const Position<frame::Machine>& commanded) const;
  Position<frame::Table> operator()(const Position<frame::Machine>& commanded) const {
    return position_mm<frame::Table>(commanded.in_mm() + error_mm(commanded));
  }
  /// The command with which the stage stands at `wanted`. Empty where the error grows faster than
  /// the way, which no stage's does.
  std::optional<Position<frame::Machine>> command_for(const Position<frame::Table>& wanted) const;

 private:
  TableGrid grid_;
  Eigen::Vector2d per_mm_;
  std::vector<Eigen::Vector2d> coefficients_mm_;
};

}  // namespace panelcal
