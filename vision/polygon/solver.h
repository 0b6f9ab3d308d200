// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/fit/residual.h"
#include "vision/polygon/model.h"

namespace panelcal::internal {

/// End of a minimisation.
struct CellSolution {
  CellState state;
  CellMatrix information = CellMatrix::Zero();  ///< J^T W J of the model's parameters, the rest 0
  bool converged = false;
};

struct CellSolverOptions {
  double full_scale = 255;
  /// Residuals of pixels near lines beyond this many sigmas count linearly; 0: plain squares.
  double huber = 0;
  double tolerance_px = 1e-3;  ///< a step below is the last one, at the pattern's rim
  double max_sigma_px = 6;
};

/// Minimises sum w rho(level - I) by Levenberg-Marquardt with analytic gradients.
///
/// Excluded pixels do not count, nor do those clipped at 0 or full scale where the model is beyond.
/// Flat pixels enter through their sums, so their number costs no time in the iterations.
///
/// Cost   about 0.1 us a pixel near a line and iteration
/// Source Nocedal and Wright 2006, 10.3; Huber 1964
CellSolution solve_cells(const CellModel& model,
                         const std::vector<CellPixel>& pixels,
                         CellState start,
                         const CellSolverOptions& options);

/// Half of the pattern's extent, pattern units.
double half_extent(const CellPattern& pattern);

}  // namespace panelcal::internal
