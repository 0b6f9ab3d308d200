// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/short_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "calib/base/statistics/random.h"

namespace panelcal::internal {
namespace {

using PathOrder = std::vector<std::size_t>;

/// Gains below a nanometre are rounding.
constexpr double kPathGain_mm = 1e-6;

auto place_at(const PathOrder& order, std::size_t position) {
  return static_cast<Eigen::Index>(order[position]);
}

/// Held and Karp: the shortest way from one place through every subset that ends at each place.
class ExactPath {
 public:
  explicit ExactPath(const PathCosts& costs)
      : costs_(costs),
        n_(costs.size()),
        shortest_(std::size_t{1} << n_),
        before_(std::size_t{1} << n_) {}

  PathOrder best() {
    PathOrder out;
    for (std::size_t first = 0; first < n_; ++first) search_from(first, out);
    return out;
  }

 private:
  double between(std::size_t a, std::size_t b) const {
    return costs_.between(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
  }

  void search_from(std::size_t first, PathOrder& out) {
    for (auto& row : shortest_) row.fill(std::numeric_limits<double>::infinity());
    shortest_[std::size_t{1} << first][first] = 0;
    for (std::size_t subset = 1; subset < shortest_.size(); ++subset) {
      for (std::size_t last = 0; last < n_; ++last) {
        if (std::isinf(shortest_[subset][last])) continue;
        for (std::size_t next = 0; next < n_; ++next) {
          const std::size_t with = subset | std::size_t{1} << next;
          const double cost = shortest_[subset][last] + between(last, next);
          if (with == subset || cost >= shortest_[with][next]) continue;
          shortest_[with][next] = cost;
          before_[with][next] = last;
        }
      }
    }
    const std::size_t all = shortest_.size() - 1;
    for (std::size_t last = 0; last < n_; ++last) {
      if (n_ > 1 && last == first) continue;
      const double cost = shortest_[all][last] + costs_.around(static_cast<Eigen::Index>(last),
                                                               static_cast<Eigen::Index>(first));
      if (cost >= best_cost_) continue;
      best_cost_ = cost;
      out = path_to(last);
    }
  }

  PathOrder path_to(std::size_t last) const {
    PathOrder order;
    for (std::size_t subset = shortest_.size() - 1; subset != 0;) {
      order.push_back(last);
      const std::size_t rest = subset & ~(std::size_t{1} << last);
      last = before_[subset][last];
      subset = rest;
    }
    std::ranges::reverse(order);
    return order;
  }

  const PathCosts& costs_;
  std::size_t n_;
  std::vector<std::array<double, kMostExactPath>> shortest_;
  std::vector<std::array<std::size_t, kMostExactPath>> before_;
  double best_cost_ = std::numeric_limits<double>::infinity();
};

/// Local search over the ring of places, one link of which is the one around.
class PathSearch {
 public:
  PathSearch(const PathCosts& costs, PathOrder order)
      : costs_(costs), n_(order.size()), order_(std::move(order)) {}

  PathOrder best() {
    descend();
    PathOrder best = order_;
    double best_cost = costs_.of(best);
    Random random(1);
    const std::size_t n_bridges = std::clamp<std::size_t>(kBridgeWork / (n_ * n_), 50, 2000);
    for (std::size_t i = 0; i < n_bridges; ++i) {
      bridge(random);
      descend();
      const double cost = costs_.of(order_);
      if (cost < best_cost - kPathGain_mm) {
        best_cost = cost;
        best = order_;
      } else {
        order_ = best;
      }
    }
    return best;
  }

 private:
  static constexpr std::size_t kBridgeWork = 1'000'000;
  static constexpr std::size_t kLongestMoved = 3;

  /// The link from place `a` at position `at` - 1 to place `b` at `at`, of which n is the one
  /// around.
  double link(std::size_t at, std::size_t a, std::size_t b) const {
    const auto& costs = at % n_ == 0 ? costs_.around : costs_.between;
    return costs(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
  }
  std::size_t before(std::size_t at) const { return order_[(at + n_ - 1) % n_]; }
  std::size_t behind(std::size_t at) const { return order_[at % n_]; }

  void descend() {
    for (bool has_changed = true; has_changed;) {
      has_changed = false;
      for (std::size_t i = 0; i < n_; ++i) {
        for (std::size_t j = i + 2; j <= n_; ++j) {
          if (reverse(i, j)) has_changed = true;
        }
      }
      for (std::size_t i = 0; i < n_; ++i) {
        for (std::size_t length = 1; length <= kLongestMoved && i + length < n_; ++length) {
          for (std::size_t to = 0; to <= n_; ++to) {
            if (move(i, i + length, to)) has_changed = true;
          }
        }
      }
    }
  }

  /// Turns the places at [i, j) round if that costs less.
  bool reverse(std::size_t i, std::size_t j) {
    const std::size_t a = order_[i];
    const std::size_t b = order_[j - 1];
    const double gain = i == 0 && j == n_ ? link(0, b, a) - link(0, a, b)
                                          : link(i, before(i), a) + link(j, b, behind(j)) -
                                                link(i, before(i), b) - link(j, a, behind(j));
    if (gain < kPathGain_mm) return false;
    std::reverse(at(i), at(j));
    return true;
  }

  /// Puts the places at [i, j) in front of what stands at `to`, turned round or not, if that costs
  /// less. It exchanges them with what lies between.
  bool move(std::size_t i, std::size_t j, std::size_t to) {
    if (to >= i && to <= j) return false;
    const bool is_forward = to > j;
    const std::size_t low = is_forward ? i : to;
    const std::size_t middle = is_forward ? j : i;
    const std::size_t high = is_forward ? to : j;
    const std::size_t a = order_[low];
    const std::size_t b = order_[middle - 1];
    const std::size_t c = order_[middle];
    const std::size_t d = order_[high - 1];
    // Without turning, [a b][c d] becomes [c d][a b]; turning exchanges the ends of what moved.
    const auto cost_of =
        [&](std::size_t first, std::size_t left, std::size_t right, std::size_t last) {
          const double inner = link(1, left, right);
          if (low == 0 && high == n_) return inner + link(0, last, first);
          return inner + link(low, before(low), first) + link(high, last, behind(high));
        };
    const double now = cost_of(a, b, c, d);
    const double straight = cost_of(c, d, a, b);
    const double turned = is_forward ? cost_of(c, d, b, a) : cost_of(d, c, a, b);
    if (now - std::min(straight, turned) < kPathGain_mm) return false;
    if (turned < straight) std::reverse(at(i), at(j));
    std::rotate(at(low), at(middle), at(high));
    return true;
  }

  /// Exchanges two neighbouring stretches: what no single move above undoes.
  void bridge(Random& random) {
    std::array<std::size_t, 3> cuts{};
    for (std::size_t& cut : cuts) {
      cut = static_cast<std::size_t>(random.uniform() * static_cast<double>(n_ + 1));
    }
    std::ranges::sort(cuts);
    std::rotate(at(cuts[0]), at(cuts[1]), at(cuts[2]));
  }

  PathOrder::iterator at(std::size_t position) {
    return order_.begin() + static_cast<std::ptrdiff_t>(position);
  }

  const PathCosts& costs_;
  std::size_t n_;
  PathOrder order_;
};

}  // namespace

double PathCosts::of(const std::vector<std::size_t>& order) const {
  if (order.empty()) return 0;
  double sum = around(place_at(order, order.size() - 1), place_at(order, 0));
  for (std::size_t i = 1; i < order.size(); ++i) {
    sum += between(place_at(order, i - 1), place_at(order, i));
  }
  return sum;
}

std::vector<std::size_t> short_path(const PathCosts& costs, std::vector<std::size_t> order) {
  if (order.size() < 2) return order;
  const double given = costs.of(order);
  std::vector<std::size_t> found =
      order.size() <= kMostExactPath ? ExactPath(costs).best() : PathSearch(costs, order).best();
  // A tie stays as the user wrote it.
  return costs.of(found) < given - kPathGain_mm ? found : order;
}

}  // namespace panelcal::internal
