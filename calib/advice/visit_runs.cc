// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/visit_runs.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace panelcal {
namespace {

using Place = Position<frame::Nominal>;
using Order = std::vector<std::size_t>;

/// Gains below a nanometre are rounding.
constexpr double kRunGain_mm = 1e-6;

double run_distance_mm(const Place& a, const Place& b) {
  return (a - b).in_mm().norm();
}

/// The inner orders of order_within_runs, one per kind.
class InnerOrders {
 public:
  InnerOrders(std::span<const Place> places, std::span<const VisitRun> runs)
      : places_(places), runs_(runs) {
    for (std::size_t i = 0; i < runs.size(); ++i) {
      runs_of_[runs[i].kind].push_back(i);
      Order& inner = inner_[runs[i].kind];
      inner.resize(runs[i].places.size());
      std::iota(inner.begin(), inner.end(), std::size_t{0});
    }
  }

  Order best() {
    constexpr int kExchangePasses = 10;
    bool has_changed = true;
    for (int pass = 0; pass < kExchangePasses && has_changed; ++pass) {
      has_changed = false;
      for (auto& [kind, inner] : inner_) has_changed = improve(kind, inner) || has_changed;
    }
    Order order;
    for (const VisitRun& run : runs_) {
      for (const std::size_t k : inner_.at(run.kind)) order.push_back(run.places[k]);
    }
    return order;
  }

 private:
  bool improve(std::size_t kind, Order& inner) {
    constexpr std::size_t kAllOrders = 5;
    double best_mm = length_mm(kind);
    Order best = inner;
    const auto keep_if_better = [&] {
      const double here_mm = length_mm(kind);
      if (here_mm > best_mm - kRunGain_mm) return false;
      best_mm = here_mm;
      best = inner;
      return true;
    };
    bool has_changed = false;
    if (inner.size() <= kAllOrders) {
      std::ranges::sort(inner);
      do {
        has_changed = keep_if_better() || has_changed;
      } while (std::ranges::next_permutation(inner).found);
    } else {
      for (std::size_t i = 0; i < inner.size(); ++i) {
        for (std::size_t j = i + 1; j < inner.size(); ++j) {
          std::swap(inner[i], inner[j]);
          has_changed = keep_if_better() || has_changed;
          inner = best;
        }
      }
    }
    inner = best;
    return has_changed;
  }

  const Place& place(std::size_t i_run, std::size_t k) const {
    const VisitRun& run = runs_[i_run];
    return places_[run.places[inner_.at(run.kind)[k]]];
  }
  double link_mm(std::size_t i_run) const {
    if (i_run == 0 || i_run >= runs_.size()) return 0;
    return run_distance_mm(place(i_run - 1, runs_[i_run - 1].places.size() - 1), place(i_run, 0));
  }

  /// Of all that the inner order of a kind decides.
  double length_mm(std::size_t kind) const {
    double sum_mm = 0;
    for (const std::size_t i : runs_of_.at(kind)) {
      for (std::size_t k = 1; k < runs_[i].places.size(); ++k) {
        sum_mm += run_distance_mm(place(i, k - 1), place(i, k));
      }
      sum_mm += link_mm(i);
      if (i + 1 < runs_.size() && runs_[i + 1].kind != kind) sum_mm += link_mm(i + 1);
    }
    return sum_mm;
  }

  std::span<const Place> places_;
  std::span<const VisitRun> runs_;
  std::map<std::size_t, Order> runs_of_;
  std::map<std::size_t, Order> inner_;
};

}  // namespace

std::vector<std::size_t> order_within_runs(std::span<const Place> places,
                                           std::span<const VisitRun> runs) {
  return InnerOrders(places, runs).best();
}

}  // namespace panelcal
