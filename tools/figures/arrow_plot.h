// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace panelcal {

/// Small vectors at places, drawn so much longer than true that they can be seen.
struct ArrowPlot {
  struct Arrow {
    Eigen::Vector2d at;    ///< in the unit of places
    Eigen::Vector2d size;  ///< in the unit of arrows, same directions
  };
  std::string title;
  std::string place_unit;                         ///< "px", "mm"
  std::string arrow_unit;                         ///< "px", "um"
  Eigen::Vector2d low = Eigen::Vector2d::Zero();  ///< the shown area
  Eigen::Vector2d high = Eigen::Vector2d::Ones();
  bool y_is_down = false;
  std::vector<Arrow> arrows;
};

/// The plot as an SVG with a frame, its corners' coordinates, and a reference arrow of a round
/// length. Arrows that are not finite are left out.
///
/// Precondition: low < high, finite
std::string arrow_svg(const ArrowPlot& plot);

}  // namespace panelcal
