// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/polygon/model.h"

namespace panelcal::internal {

/// A pattern as it was fitted to a picture.
struct CellFit {
  bool converged = false;
  CellState state;
  CellMatrix cov = CellMatrix::Zero();  ///< of the model's n_parameters(), inflated if need be
  double noise_outside = 1;             ///< sigma of the residuals, grey levels
  double noise_inside = 1;
  double rim_noise = 0;        ///< sigma of the residuals near the lines
  double rim_excess = 1;       ///< variance near the lines over what the noise predicts, at least 1
  double excluded = 0;         ///< part of the pixels near the lines left out
  double correlation = 0;      ///< of model and picture near the lines, camera noise aside, 0 to 1
  double visible = 0;          ///< part of the outline that is seen and looks like an edge
  double weakest_side = 1;     ///< squares: part of the side that is seen least
  double evenness = 1;         ///< squares: least step of level at a side over the largest
  double intact = 1;           ///< part of the targets' face that looks like it
  double clipped = 0;          ///< part of the pixels near the lines at either end of the scale
  double outside_picture = 0;  ///< part of the outline that is not in the picture
  std::vector<CellPixel> pixels;  ///< with weights and exclusions as the last fit used them
};

}  // namespace panelcal::internal
