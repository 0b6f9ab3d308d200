// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "tests/bench/locate/scene.h"

namespace panelcal::bench {

/// Place of an impostor, and the mark that it replaces.
struct Stage {
  const Camera& camera;
  const Mark& mark;  ///< the one that is not there
  Eigen::Vector2d center_px;
  double level = 0;       ///< of marks, 0 to 1
  double background = 0;  ///< of the board, 0 to 1
};

/// A kind of picture that does not show the mark but may look like it.
struct Impostor {
  std::string name;
  std::function<std::vector<Feature>(const Stage&, Random&)> draw;
  bool is_tilted = false;  ///< the board leans further than the mark's tolerance allows
};

/// Wrong sizes (8 % and more), half marks, other shapes, clutter, bare board, boards that lean.
std::vector<Impostor> impostors_of(Shape shape);

}  // namespace panelcal::bench
