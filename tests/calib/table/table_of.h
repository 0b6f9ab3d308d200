// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "calib/correction/table_map.h"

namespace panelcal::test {

/// The map of a table whose error is known: exactly, if it is a polynomial of the third degree.
///
/// A cubic B-spline of coefficients f(k) is f + h^2 f'' / 6 at its knots, for such an f.
inline TableMap table_of(const TableGrid& grid,
                         const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& error_mm) {
  const Eigen::Vector2d step_mm = grid.step_mm();
  const Eigen::Vector2d dx_mm(step_mm.x(), 0);
  const Eigen::Vector2d dy_mm(0, step_mm.y());
  std::vector<Eigen::Vector2d> coefficients_mm;
  for (int j = -1; j <= grid.ny + 1; ++j) {
    for (int i = -1; i <= grid.nx + 1; ++i) {
      const Eigen::Vector2d at_mm = grid.low_mm + i * dx_mm + j * dy_mm;
      const Eigen::Vector2d middle_mm = error_mm(at_mm);
      const Eigen::Vector2d second_mm = error_mm(at_mm + dx_mm) + error_mm(at_mm - dx_mm) +
                                        error_mm(at_mm + dy_mm) + error_mm(at_mm - dy_mm) -
                                        4 * middle_mm;
      coefficients_mm.push_back(middle_mm - second_mm / 6);
    }
  }
  return {grid, std::move(coefficients_mm)};
}

}  // namespace panelcal::test
