// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/visit_runs.h"

#include <map>
#include <numeric>
#include <utility>

#include "calib/advice/short_path.h"
#include <Eigen/Core>

namespace panelcal {
namespace {

using Place = Position<frame::Nominal>;
using Order = std::vector<std::size_t>;

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
    const Order found = internal::short_path(costs_of(kind), inner);
    return std::exchange(inner, found) != found;
  }

  const Place& place(std::size_t i_run, std::size_t k) const {
    const VisitRun& run = runs_[i_run];
    return places_[run.places[inner_.at(run.kind)[k]]];
  }
  /// Costs that the inner order of a kind decides, as long as the other kinds keep theirs.
  internal::PathCosts costs_of(std::size_t kind) const {
    const Order& of_kind = runs_of_.at(kind);
    const auto n = static_cast<Eigen::Index>(inner_.at(kind).size());
    internal::PathCosts costs{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, n)};
    const auto at = [&](std::size_t i_run, Eigen::Index k) -> const Place& {
      return places_[runs_[i_run].places[static_cast<std::size_t>(k)]];
    };
    for (const std::size_t i : of_kind) {
      const bool has_before = i > 0;
      const bool has_behind = i + 1 < runs_.size();
      const bool repeats = has_behind && runs_[i + 1].kind == kind;
      for (Eigen::Index last = 0; last < n; ++last) {
        for (Eigen::Index first = 0; first < n; ++first) {
          costs.between(last, first) += run_distance_mm(at(i, last), at(i, first));
          double& around = costs.around(last, first);
          if (has_before && runs_[i - 1].kind != kind) {
            around += run_distance_mm(place(i - 1, runs_[i - 1].places.size() - 1), at(i, first));
          }
          if (repeats) around += run_distance_mm(at(i, last), at(i + 1, first));
          if (has_behind && !repeats) around += run_distance_mm(at(i, last), place(i + 1, 0));
        }
      }
    }
    return costs;
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
