// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/convex_hull.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "calib/base/plane_vectors.h"

namespace panelcal {
namespace {

using Place = Position<frame::Nominal>;

bool turns_left(const Place& a, const Place& b, const Place& c) {
  return internal::cross((b - a).in_mm(), (c - b).in_mm()) > 0;
}

bool is_before(const Place& a, const Place& b) {
  return a.in_mm().x() < b.in_mm().x() ||
         (a.in_mm().x() == b.in_mm().x() && a.in_mm().y() < b.in_mm().y());
}

/// Takes the places in order and keeps the chain that only turns left.
template <class Iterator>
void append_chain(Iterator from, Iterator to, std::vector<Place>& hull) {
  const std::size_t begin = hull.size();
  for (; from != to; ++from) {
    while (hull.size() >= begin + 2 && !turns_left(hull[hull.size() - 2], hull.back(), *from)) {
      hull.pop_back();
    }
    hull.push_back(*from);
  }
  hull.pop_back();  // where the other chain begins
}

double distance_to_side(const Place& a, const Place& b, const Place& p) {
  const Eigen::Vector2d side = (b - a).in_mm();
  const Eigen::Vector2d v = (p - a).in_mm();
  const double length2 = side.squaredNorm();
  const double along = length2 > 0 ? std::clamp(side.dot(v) / length2, 0.0, 1.0) : 0;
  return (v - along * side).norm();
}

}  // namespace

std::vector<Place> convex_hull(std::span<const Place> places) {
  std::vector<Place> sorted(places.begin(), places.end());
  std::ranges::sort(sorted, is_before);
  const auto is_same = [](const Place& a, const Place& b) { return a.in_mm() == b.in_mm(); };
  sorted.erase(std::unique(sorted.begin(), sorted.end(), is_same), sorted.end());
  if (sorted.size() < 3) return sorted;
  std::vector<Place> hull;
  append_chain(sorted.begin(), sorted.end(), hull);
  append_chain(sorted.rbegin(), sorted.rend(), hull);
  return hull;
}

Length distance_outside(std::span<const Place> corners, const Place& p) {
  if (corners.size() == 1) return mm((p - corners[0]).in_mm().norm());
  double nearest_mm = std::numeric_limits<double>::infinity();
  bool is_inside = corners.size() >= 3;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Place& a = corners[i];
    const Place& b = corners[(i + 1) % corners.size()];
    if (internal::cross((b - a).in_mm(), (p - a).in_mm()) < 0) is_inside = false;
    nearest_mm = std::min(nearest_mm, distance_to_side(a, b, p));
  }
  return is_inside ? mm(0) : mm(nearest_mm);
}

void HullBuilder::shrink() {
  waiting_ = corners();
}

std::vector<Place> HullBuilder::corners() const {
  std::vector<Place> hull = convex_hull(waiting_);
  if (hull.size() <= kMost) return hull;
  std::set<std::size_t> outermost;
  for (std::size_t k = 0; k < kMost; ++k) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / kMost;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    std::size_t best = 0;
    for (std::size_t i = 1; i < hull.size(); ++i) {
      if (direction.dot((hull[i] - hull[best]).in_mm()) > 0) best = i;
    }
    outermost.insert(best);
  }
  std::vector<Place> kept;
  for (const std::size_t i : outermost) kept.push_back(hull[i]);
  return kept;
}

}  // namespace panelcal
