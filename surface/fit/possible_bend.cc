// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/possible_bend.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace panelcal {

Eigen::VectorXd PossibleBend::errors_mm(std::span<const Position<frame::Nominal>> places) const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(places.size()));
  for (Eigen::Index i = 0; i < out.size(); ++i) {
    const Eigen::Vector2d apart_mm =
        places[static_cast<std::size_t>(i)].in_mm() - this->place.in_mm();
    const double by_reach = apart_mm.norm() / reach.in_mm();
    out[i] = height.in_mm() * std::exp(-0.5 * by_reach * by_reach);
  }
  return out;
}

PossibleBend possible_bend(const ProbePoint& wild,
                           Length deviation,
                           std::span<const ProbePoint> kept) {
  constexpr std::size_t kAround = 4;
  std::vector<double> distances_mm;
  for (const ProbePoint& point : kept) {
    distances_mm.push_back((point.place.in_mm() - wild.place.in_mm()).norm());
  }
  std::ranges::sort(distances_mm);
  const double reach_mm = distances_mm[std::min(kAround, distances_mm.size()) - 1];
  return {wild.place, deviation, mm(reach_mm)};
}

}  // namespace panelcal
