// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/cli/options/surface_options.h"

namespace panelcal {

/// `panelcal align apply` and `panelcal filter`.
struct ApplyOptions {
  std::string program;  ///< G-code; filter: or a program to drill
  std::string machine;
  std::string align;
  double valid_hours = 4;
  std::string output = "-";
  double tolerance_um = 2;  ///< of arcs and bent lines
  /// Its map (may be empty), the unit of the program, and how it is levelled; --max-sigma-um is of
  /// the places in X and Y.
  SurfaceOptions surface;
};

}  // namespace panelcal
