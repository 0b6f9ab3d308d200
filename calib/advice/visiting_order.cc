// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/visiting_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <numeric>

#include "calib/advice/short_path.h"
#include <Eigen/Core>

namespace panelcal {
namespace {

using Place = Position<frame::Nominal>;
using Order = std::vector<std::size_t>;

constexpr std::size_t kNeighbors = 8;
constexpr std::size_t kMany = 20'000;
constexpr std::size_t kMostMoved = 1000;
constexpr std::size_t kLongestSegment = 3;
/// Gains below a nanometre are rounding.
constexpr double kVisitGain_mm = 1e-6;

double visit_distance_mm(const Place& a, const Place& b) {
  return (a - b).in_mm().norm();
}

/// Held and Karp: the shortest way through every subset of places that ends at each of them.
Order exact_order(std::span<const Place> places, std::span<const int> phases) {
  const std::size_t n = places.size();
  const std::size_t n_subsets = std::size_t{1} << n;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<std::array<double, kMostExact>> shortest(n_subsets);
  std::vector<std::array<std::size_t, kMostExact>> before(n_subsets);
  for (auto& row : shortest) row.fill(kFar);
  const auto may_come = [&](std::size_t i, std::size_t subset) {
    for (std::size_t j = 0; j < n; ++j) {
      if (phases[j] < phases[i] && (subset >> j & 1U) == 0) return false;
    }
    return (subset >> i & 1U) == 0;
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (may_come(i, 0)) shortest[std::size_t{1} << i][i] = 0;
  }
  for (std::size_t subset = 1; subset < n_subsets; ++subset) {
    for (std::size_t last = 0; last < n; ++last) {
      if (shortest[subset][last] == kFar) continue;
      for (std::size_t next = 0; next < n; ++next) {
        if (!may_come(next, subset)) continue;
        const double length_mm =
            shortest[subset][last] + visit_distance_mm(places[last], places[next]);
        const std::size_t with = subset | std::size_t{1} << next;
        if (length_mm >= shortest[with][next]) continue;
        shortest[with][next] = length_mm;
        before[with][next] = last;
      }
    }
  }
  std::size_t subset = n_subsets - 1;
  auto last = static_cast<std::size_t>(
      std::min_element(shortest[subset].begin(), shortest[subset].begin() + static_cast<int>(n)) -
      shortest[subset].begin());
  Order order;
  while (subset != 0) {
    order.push_back(last);
    const std::size_t rest = subset & ~(std::size_t{1} << last);
    last = before[subset][last];
    subset = rest;
  }
  std::ranges::reverse(order);
  return order;
}

/// Square cells with about two places each, to find near ones.
class Cells {
 public:
  explicit Cells(std::span<const Place> places) : places_(places) {
    low_mm_ = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Vector2d high_mm = -low_mm_;
    for (const Place& p : places) {
      low_mm_ = low_mm_.cwiseMin(p.in_mm());
      high_mm = high_mm.cwiseMax(p.in_mm());
    }
    const Eigen::Vector2d size_mm = (high_mm - low_mm_).cwiseMax(1e-6);
    const double n = static_cast<double>(places.size());
    // At most some 2n cells, however long and thin the whole is.
    side_mm_ = std::max(std::sqrt(size_mm.prod() / n * 2), size_mm.maxCoeff() / n);
    n_x_ = static_cast<int>(size_mm.x() / side_mm_) + 1;
    n_y_ = static_cast<int>(size_mm.y() / side_mm_) + 1;
    cells_.resize(static_cast<std::size_t>(n_x_) * static_cast<std::size_t>(n_y_));
    for (std::size_t i = 0; i < places.size(); ++i) cell(places[i]).push_back(i);
  }

  void remove(std::size_t i) { std::erase(cell(places_[i]), i); }

  /// Up to `n` places nearest to `p` for which `counts` holds, the nearest first.
  template <class Predicate>
  Order nearest(const Place& p, std::size_t n, Predicate counts) const {
    std::vector<std::pair<double, std::size_t>> found;
    const auto [x, y] = index(p);
    for (int ring = 0; ring <= std::max(n_x_, n_y_); ++ring) {
      for_each_in_ring(x, y, ring, [&](std::size_t i) {
        if (counts(i)) found.emplace_back(visit_distance_mm(p, places_[i]), i);
      });
      // Places in farther rings are at least this far.
      const double sure_mm = ring * side_mm_;
      const auto n_sure = std::ranges::count_if(
          found, [sure_mm](const auto& candidate) { return candidate.first <= sure_mm; });
      if (n_sure >= static_cast<std::ptrdiff_t>(n)) break;
    }
    std::ranges::sort(found);
    Order out;
    for (std::size_t i = 0; i < std::min(n, found.size()); ++i) out.push_back(found[i].second);
    return out;
  }

 private:
  std::pair<int, int> index(const Place& p) const {
    const Eigen::Vector2d at = (p.in_mm() - low_mm_) / side_mm_;
    return {std::clamp(static_cast<int>(at.x()), 0, n_x_ - 1),
            std::clamp(static_cast<int>(at.y()), 0, n_y_ - 1)};
  }
  std::size_t number(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(n_x_) +
           static_cast<std::size_t>(x);
  }
  Order& cell(const Place& p) {
    const auto [x, y] = index(p);
    return cells_[number(x, y)];
  }

  template <class Visit>
  void for_each_in_ring(int x, int y, int ring, Visit visit) const {
    for (int dy = -ring; dy <= ring; ++dy) {
      if (y + dy < 0 || y + dy >= n_y_) continue;
      const int step = std::abs(dy) == ring || ring == 0 ? 1 : 2 * ring;
      for (int dx = -ring; dx <= ring; dx += step) {
        if (x + dx < 0 || x + dx >= n_x_) continue;
        for (const std::size_t i : cells_[number(x + dx, y + dy)]) visit(i);
      }
    }
  }

  std::span<const Place> places_;
  Eigen::Vector2d low_mm_;
  double side_mm_ = 1;
  int n_x_ = 1;
  int n_y_ = 1;
  std::vector<Order> cells_;
};

/// Improves an order by moves that leave every place within its phase.
class Improver {
 public:
  Improver(std::span<const Place> places,
           std::span<const int> phases,
           const std::vector<Order>& neighbors,
           Order order)
      : places_(places), neighbors_(neighbors), order_(std::move(order)), at_(order_.size()) {
    low_.resize(order_.size());
    high_.resize(order_.size());
    for (std::size_t p = 0; p < order_.size(); ++p) {
      at_[order_[p]] = p;
      const bool begins = p == 0 || phases[order_[p]] != phases[order_[p - 1]];
      low_[order_[p]] = begins ? p : low_[order_[p - 1]];
    }
    for (std::size_t p = order_.size(); p-- > 0;) {
      const bool ends = p + 1 == order_.size() || phases[order_[p]] != phases[order_[p + 1]];
      high_[order_[p]] = ends ? p : high_[order_[p + 1]];
    }
    most_moved_ = order_.size() > kMany ? kMostMoved : order_.size();
  }

  Order improved() {
    waiting_.assign(order_.begin(), order_.end());
    is_waiting_.assign(order_.size(), true);
    while (!waiting_.empty()) {
      const std::size_t city = waiting_.front();
      waiting_.pop_front();
      is_waiting_[city] = false;
      while (improve(city)) {
      }
    }
    return std::move(order_);
  }

 private:
  /// Distance between the places at two positions; 0 beyond the ends. Position 0 is before the
  /// first place.
  double gap_mm(std::size_t a, std::size_t b) const {
    if (a == 0 || b == 0 || a > order_.size() || b > order_.size()) return 0;
    return visit_distance_mm(places_[order_[a - 1]], places_[order_[b - 1]]);
  }

  void wake(std::size_t position) {
    if (position >= order_.size()) return;
    const std::size_t city = order_[position];
    if (is_waiting_[city]) return;
    is_waiting_[city] = true;
    waiting_.push_back(city);
  }

  /// Turns the places from position `first` to `last` round if that is shorter.
  bool reverse(std::size_t first, std::size_t last) {
    if (first >= last || last - first > most_moved_) return false;
    const std::size_t a = first + 1;
    const std::size_t b = last + 1;
    const double gain_mm =
        gap_mm(a - 1, a) + gap_mm(b, b + 1) - gap_mm(a - 1, b) - gap_mm(a, b + 1);
    if (gain_mm < kVisitGain_mm) return false;
    std::reverse(order_.begin() + static_cast<std::ptrdiff_t>(first),
                 order_.begin() + static_cast<std::ptrdiff_t>(last) + 1);
    settle(first, last);
    return true;
  }

  /// Puts the places from `first` to `last` behind position `behind`, turned round or not; -1 is
  /// before all.
  bool move(std::size_t first, std::size_t last, std::ptrdiff_t behind) {
    const auto f = static_cast<std::ptrdiff_t>(first);
    const auto l = static_cast<std::ptrdiff_t>(last);
    if (behind >= f - 1 && behind <= l) return false;
    const std::size_t a = first + 1;
    const std::size_t b = last + 1;
    const auto d = static_cast<std::size_t>(behind + 1);
    const double freed_mm = gap_mm(a - 1, a) + gap_mm(b, b + 1) - gap_mm(a - 1, b + 1);
    const double straight_mm = gap_mm(d, a) + gap_mm(b, d + 1) - gap_mm(d, d + 1);
    const double turned_mm = gap_mm(d, b) + gap_mm(a, d + 1) - gap_mm(d, d + 1);
    if (freed_mm - std::min(straight_mm, turned_mm) < kVisitGain_mm) return false;
    const std::ptrdiff_t begin = std::min(f, behind + 1);
    const std::ptrdiff_t end = std::max(l, behind);
    if (static_cast<std::size_t>(end - begin) > most_moved_) return false;
    if (turned_mm < straight_mm) std::reverse(order_.begin() + f, order_.begin() + l + 1);
    if (behind < f) {
      std::rotate(order_.begin() + begin, order_.begin() + f, order_.begin() + l + 1);
    } else {
      std::rotate(order_.begin() + f, order_.begin() + l + 1, order_.begin() + end + 1);
    }
    settle(static_cast<std::size_t>(begin), static_cast<std::size_t>(end));
    wake(static_cast<std::size_t>(f));
    wake(static_cast<std::size_t>(l) + 1);
    return true;
  }

  void settle(std::size_t first, std::size_t last) {
    for (std::size_t p = first; p <= last; ++p) at_[order_[p]] = p;
    for (const std::size_t p : {first, last, last + 1}) wake(p);
    if (first > 0) wake(first - 1);
  }

  bool improve(std::size_t city) {
    const std::size_t low = low_[city];
    const std::size_t high = high_[city];
    if (reverse(low, at_[city]) || reverse(at_[city], high)) return true;
    for (const std::size_t other : neighbors_[city]) {
      const std::size_t p = at_[city];
      const std::size_t q = at_[other];
      // city's successor, or its predecessor, becomes `other`.
      if (p < q ? reverse(p + 1, q) : reverse(q + 1, p)) return true;
      if (p < q ? reverse(p, q - 1) : reverse(q, p - 1)) return true;
      for (std::size_t length = 1; length <= kLongestSegment; ++length) {
        // A segment that begins or ends with city goes to either side of `other`.
        for (const bool begins : {true, false}) {
          if (begins ? p + length - 1 > high : p < low + length - 1) continue;
          const std::size_t first = begins ? p : p - (length - 1);
          const auto behind = static_cast<std::ptrdiff_t>(q);
          if (q >= first && q < first + length) continue;
          if (move(first, first + length - 1, behind)) return true;
          if (move(first, first + length - 1, behind - 1)) return true;
        }
      }
    }
    return false;
  }

  std::span<const Place> places_;
  const std::vector<Order>& neighbors_;
  Order order_;
  Order at_;    ///< position by place
  Order low_;   ///< first position of a place's phase
  Order high_;  ///< last one
  std::size_t most_moved_ = 0;
  std::deque<std::size_t> waiting_;
  std::vector<bool> is_waiting_;
};

/// Always the nearest place of the phase; a phase begins nearest to the end of the one before.
Order greedy_order(std::span<const Place> places,
                   std::span<const int> phases,
                   const Order& by_phase) {
  Cells cells(places);
  std::map<int, std::size_t> left;
  for (const int phase : phases) ++left[phase];
  Order order;
  std::size_t here = by_phase.front();
  for (const auto& [phase, n] : left) {
    for (std::size_t k = 0; k < n; ++k) {
      const Order next = cells.nearest(
          places[here], 1, [&, wanted = phase](std::size_t i) { return phases[i] == wanted; });
      here = next.front();
      cells.remove(here);
      order.push_back(here);
    }
  }
  return order;
}

std::vector<Order> near_ones(std::span<const Place> places, std::span<const int> phases) {
  const Cells cells(places);
  std::vector<Order> neighbors;
  neighbors.reserve(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    neighbors.push_back(cells.nearest(
        places[i], kNeighbors, [&](std::size_t j) { return j != i && phases[j] == phases[i]; }));
  }
  return neighbors;
}

/// Searches the order of the places at [begin, end), which are of one phase, between what is before
/// and behind them.
bool search_phase(std::span<const Place> places, Order& order, std::size_t begin, std::size_t end) {
  const auto n = static_cast<Eigen::Index>(end - begin);
  internal::PathCosts costs{Eigen::MatrixXd(n, n), Eigen::MatrixXd::Zero(n, n)};
  const auto at = [&](Eigen::Index i) -> const Place& {
    return places[order[begin + static_cast<std::size_t>(i)]];
  };
  for (Eigen::Index last = 0; last < n; ++last) {
    for (Eigen::Index first = 0; first < n; ++first) {
      costs.between(last, first) = visit_distance_mm(at(last), at(first));
      double& around = costs.around(last, first);
      if (begin > 0) around += visit_distance_mm(places[order[begin - 1]], at(first));
      if (end < order.size()) around += visit_distance_mm(at(last), places[order[end]]);
    }
  }
  Order inner(end - begin);
  std::iota(inner.begin(), inner.end(), std::size_t{0});
  Order found = internal::short_path(costs, inner);
  if (found == inner) return false;
  for (std::size_t& i : found) i = order[begin + i];
  std::ranges::copy(found, order.begin() + static_cast<std::ptrdiff_t>(begin));
  return true;
}

/// One phase after the other, until the ends of none move any more.
void search_phases(std::span<const Place> places, std::span<const int> phases, Order& order) {
  constexpr int kMostRounds = 5;
  bool has_changed = true;
  for (int round = 0; round < kMostRounds && has_changed; ++round) {
    has_changed = false;
    for (std::size_t begin = 0; begin < order.size();) {
      std::size_t end = begin + 1;
      while (end < order.size() && phases[order[end]] == phases[order[begin]]) ++end;
      if (end - begin <= kMostSearched) {
        has_changed = search_phase(places, order, begin, end) || has_changed;
      }
      begin = end;
    }
  }
}

}  // namespace

Length way_length(std::span<const Place> places, std::span<const std::size_t> order) {
  double sum_mm = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    sum_mm += visit_distance_mm(places[order[i - 1]], places[order[i]]);
  }
  return mm(sum_mm);
}

std::vector<std::size_t> short_order(std::span<const Place> places, std::span<const int> phases) {
  if (places.empty()) return {};
  if (places.size() <= kMostExact) return exact_order(places, phases);
  Order given(places.size());
  std::iota(given.begin(), given.end(), std::size_t{0});
  std::ranges::stable_sort(given, {}, [&](std::size_t i) { return phases[i]; });
  const std::vector<Order> neighbors = near_ones(places, phases);
  Order from_given = Improver(places, phases, neighbors, given).improved();
  Order from_near =
      Improver(places, phases, neighbors, greedy_order(places, phases, given)).improved();
  Order best =
      way_length(places, from_near) < way_length(places, from_given) ? from_near : from_given;
  if (places.size() <= kMostSearchedInAll) search_phases(places, phases, best);
  return best;
}

}  // namespace panelcal
