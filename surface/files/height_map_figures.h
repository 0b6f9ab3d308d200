// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "surface/files/text_fields.h"

// Not installed: part of surface/files/probe_file.h.
namespace panelcal::internal {

/// The figures of the heights in the first line of heightmap.csv.
struct HeightFigures {
  double least = 0, greatest = 0, mean = 0;
  double deviation = 0;  ///< root mean square about the mean

  /// Precondition: heights is not empty.
  static HeightFigures of(std::span<const double> heights);
};

/// Compares the figures in a first line, as far as it has any, with the heights below it. Each
/// stands in a cell of its own: `min error`, `max error`, `mean` or `mean error`, and `deviation`.
///
/// Fails  measurement-file: a figure is off by more than the rounding of figures and heights
Expected<void> check_figures(const std::string& file,
                             const TextField& line,
                             std::span<const double> heights);

}  // namespace panelcal::internal
