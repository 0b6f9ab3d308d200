// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/picture.h"

namespace panelcal::surface {

std::vector<Eigen::Vector2d> hull_of(const HeightMap& map) {
  std::vector<Eigen::Vector2d> out;
  for (const auto& corner : map.hull()) out.push_back(corner.in_mm());
  return out;
}

}  // namespace panelcal::surface
