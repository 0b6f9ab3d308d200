// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/even_part.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include <Eigen/Core>

namespace panelcal::internal {
namespace {

using Eigen::Vector2d;
using Indices = std::vector<std::size_t>;

double probe_distance_mm(const ProbePoint& a, const ProbePoint& b) {
  return (a.place - b.place).in_mm().norm();
}

Indices far_apart(std::span<const ProbePoint> points, std::size_t n) {
  std::vector<double> nearest_mm(points.size(), std::numeric_limits<double>::infinity());
  Indices out = {0};
  while (out.size() < n) {
    const ProbePoint& last = points[out.back()];
    for (std::size_t i = 0; i < points.size(); ++i) {
      nearest_mm[i] = std::min(nearest_mm[i], probe_distance_mm(points[i], last));
    }
    const auto farthest = std::ranges::max_element(nearest_mm);
    out.push_back(static_cast<std::size_t>(farthest - nearest_mm.begin()));
  }
  return out;
}

void split(std::span<const ProbePoint> points,
           std::span<std::size_t> some,
           std::size_t most,
           std::vector<Indices>& out) {
  if (some.size() <= most) {
    out.emplace_back(some.begin(), some.end());
    std::ranges::sort(out.back());
    return;
  }
  Vector2d low_mm = points[some.front()].place.in_mm(), high_mm = low_mm;
  for (const std::size_t i : some) {
    low_mm = low_mm.cwiseMin(points[i].place.in_mm());
    high_mm = high_mm.cwiseMax(points[i].place.in_mm());
  }
  const Eigen::Index axis = high_mm.x() - low_mm.x() >= high_mm.y() - low_mm.y() ? 0 : 1;
  // Of the same coordinate the earlier one is less: the same halves on every machine.
  const auto key = [&](std::size_t i) { return std::pair(points[i].place.in_mm()[axis], i); };
  const std::size_t half = some.size() / 2;
  std::ranges::nth_element(some, some.begin() + static_cast<std::ptrdiff_t>(half), {}, key);
  split(points, some.first(half), most, out);
  split(points, some.subspan(half), most, out);
}

}  // namespace

std::vector<ProbePoint> even_part(std::span<const ProbePoint> points, std::size_t n) {
  std::vector<bool> is_in(points.size(), false);
  const Indices apart = far_apart(points, n / 2);
  for (const std::size_t i : apart) is_in[i] = true;
  for (const std::size_t i : apart) {
    std::optional<std::size_t> nearest;
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (is_in[k]) continue;
      if (!nearest || probe_distance_mm(points[k], points[i]) <
                          probe_distance_mm(points[*nearest], points[i])) {
        nearest = k;
      }
    }
    if (nearest) is_in[*nearest] = true;
  }
  std::vector<ProbePoint> out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_in[i]) out.push_back(points[i]);
  }
  return out;
}

std::vector<std::vector<std::size_t>> neighborhoods(std::span<const ProbePoint> points,
                                                    std::size_t most) {
  Indices all(points.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  std::vector<Indices> out;
  split(points, all, most, out);
  return out;
}

}  // namespace panelcal::internal
