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

std::optional<PossibleBend> possible_bend(const ProbePoint& wild,
                                          Length deviation,
                                          std::span<const ProbePoint> kept) {
  constexpr std::size_t kAround = 4;
  std::vector<Eigen::Vector2d> by_distance_mm;  // from the wild probe
  for (const ProbePoint& point : kept) {
    by_distance_mm.push_back(point.place.in_mm() - wild.place.in_mm());
  }
  std::ranges::sort(by_distance_mm, {}, [](const Eigen::Vector2d& p_mm) { return p_mm.norm(); });
  double reach_mm = by_distance_mm.back().norm();
  std::vector<Eigen::Vector2d> places_mm;
  for (const Eigen::Vector2d& p_mm : by_distance_mm) {
    const double same_mm = kSameProbePlace * p_mm.norm();
    const auto is_same = [&](const Eigen::Vector2d& q_mm) {
      return (p_mm - q_mm).norm() <= same_mm;
    };
    if (std::ranges::any_of(places_mm, is_same)) continue;
    places_mm.push_back(p_mm);
    if (places_mm.size() < kAround) continue;
    reach_mm = p_mm.norm();
    break;
  }
  if (by_distance_mm.front().norm() <= kSameProbePlace * reach_mm) return std::nullopt;
  return PossibleBend{wild.place, deviation, mm(reach_mm)};
}

}  // namespace panelcal
