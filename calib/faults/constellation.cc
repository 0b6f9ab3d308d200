// SPDX-License-Identifier: Apache-2.0
#include "calib/faults/constellation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/base/plane_vectors.h"
#include "calib/base/statistics/distributions.h"
#include "calib/faults/constellation_map.h"

namespace panelcal {
namespace {

using internal::ConstellationMap;
using internal::Prediction;

/// Chance that a target which its picture shows leaves no trace at all among the candidates.
constexpr double kBlank = 5e-4;
/// The same where something that does not count stands in its place: debris, a damaged mark.
constexpr double kDoubtful = 0.1;
/// Chance that a target lies a little beyond its radius; or, without one, beyond its picture.
constexpr double kBeyond = 0.01;
/// Chance that a complete set of other pads stands in for targets that are not all found.
constexpr double kStandIn = 0.05;
constexpr double kUsualFalseAlarm = 1e-3;
/// Squared distance, in sigmas, that two coordinates exceed once in a million times.
constexpr double kGate = 27.6;
/// The same, one time in twenty: nearer matches are as good as any.
constexpr double kGood = 6;
/// Combinations this much less likely than the best are not kept.
const double kNegligible = std::log(1e9);
constexpr std::size_t kMostRanked = 16;
constexpr std::size_t kMostNodes = 200'000;
/// While a target's place is less well predicted, its candidates may as well be other pads.
constexpr double kLoose_mm = 0.3;
/// Radii are round numbers: while other targets are inside, one may lie so far out.
constexpr double kEdge = 1.1;
/// A trace of a damaged mark lies off the mark's middle.
constexpr double kTrace_mm = 0.3;

double match_cost(double distance2) {
  return 0.5 * std::max(0.0, distance2 - kGood);
}

/// Depth of a place inside a convex area; negative outside.
double depth_mm(const std::array<Eigen::Vector2d, 4>& corners, const Eigen::Vector2d& place_mm) {
  double area = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d& a = corners[k];
    const Eigen::Vector2d& b = corners[(k + 1) % 4];
    area += internal::cross(a, b);
  }
  double depth = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d side = corners[(k + 1) % 4] - corners[k];
    const Eigen::Vector2d to = place_mm - corners[k];
    const double left = internal::cross(side, to) / std::max(side.norm(), 1e-12);
    depth = std::min(depth, area > 0 ? left : -left);
  }
  return depth;
}

/// A missing target, on a given map.
struct Absence {
  Presence presence = Presence::Unseen;
  double log_chance = 0;
  bool is_possible = true;  ///< false: a candidate stands there, or it is beyond the radius
};

class AssignmentSearch {
 public:
  AssignmentSearch(std::span<const ConstellationTarget> targets,
                   const ConstellationOptions& options)
      : targets_(targets),
        options_(options),
        false_alarm_(options.limits.false_alarm.value_or(kUsualFalseAlarm)),
        start_(targets, options.limits) {
    order_targets();
    for (const ConstellationTarget& target : targets) {
      double best = 0;
      for (const ConstellationCandidate& c : target.candidates) {
        if (c.counts) best = std::max(best, c.score);
      }
      best_scores_.push_back(best);
    }
  }

  Constellation result() {
    choice_.assign(targets_.size(), std::nullopt);
    descend(0, start_, 0, 0);
    Constellation out;
    out.false_alarm = false_alarm_;
    out.is_exhaustive = n_nodes_ <= kMostNodes;
    std::ranges::stable_sort(found_, std::ranges::greater{}, &Combination::log_weight);
    const double outside = std::log(kStandIn) + std::log(std::max(share_outside(), 1e-300));
    const double top = std::max(found_.empty() ? outside : found_.front().log_weight, outside);
    double sum = std::exp(outside - top);
    for (const Combination& c : found_) sum += std::exp(c.log_weight - top);
    for (Combination& c : found_) c.probability = std::exp(c.log_weight - top) / sum;
    out.outside = std::exp(outside - top) / sum;
    if (found_.size() > kMostRanked) found_.resize(kMostRanked);
    out.ranked = std::move(found_);
    return out;
  }

 private:
  /// First the one with the fewest candidates, then always the farthest: maps are well determined
  /// after two.
  void order_targets() {
    std::vector<std::size_t> left(targets_.size());
    for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
    const auto n_candidates = [&](std::size_t i) { return targets_[i].candidates.size(); };
    while (!left.empty()) {
      const auto distance = [&](std::size_t i) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const std::size_t k : order_) {
          nearest = std::min(nearest, (targets_[i].expected_mm - targets_[k].expected_mm).norm());
        }
        return nearest;
      };
      const auto next = order_.empty() ? std::ranges::min_element(left, {}, n_candidates)
                                       : std::ranges::max_element(left, {}, distance);
      order_.push_back(*next);
      left.erase(next);
    }
  }

  Absence absence(std::size_t i, const ConstellationMap& map) const {
    const ConstellationTarget& target = targets_[i];
    const Prediction at = map.predicted(target.expected_mm);
    const double sigma_mm = std::sqrt(0.5 * at.cov_mm2.trace());
    bool has_trace = false;
    for (const ConstellationCandidate& c : target.candidates) {
      const double d2 = at.distance2(c.place_mm, c.cov_mm2);
      if (c.counts && d2 < kGate) return {.is_possible = false};
      has_trace |= !c.counts && (d2 < kGate || (c.place_mm - at.place_mm).norm() < kTrace_mm);
    }
    const double off_mm = (at.place_mm - target.expected_mm).norm();
    if (target.radius_mm && off_mm - 3 * sigma_mm > kEdge * *target.radius_mm) {
      return {.is_possible = false};
    }
    if (!target.view_mm) return {};
    const double share_seen = normal_exceedance(-depth_mm(*target.view_mm, at.place_mm) / sigma_mm);
    const double share_inside =
        target.radius_mm ? normal_exceedance((off_mm - *target.radius_mm) / sigma_mm) : share_seen;
    const double unseen = target.radius_mm ? 1 - share_seen : 0;
    const double chance = has_trace ? kDoubtful : kBlank;
    Absence out;
    out.log_chance = std::log((target.radius_mm ? share_inside : 1) * share_seen * chance +
                              share_inside * unseen + (1 - share_inside) * kBeyond);
    if (share_seen > 0.5) out.presence = has_trace ? Presence::Doubtful : Presence::Blank;
    return out;
  }

  /// Least cost of everything that is left out so far; infinite if it cannot be.
  double absent_cost(std::size_t n_decided, const ConstellationMap& map) const {
    double cost = 0;
    for (std::size_t k = 0; k < n_decided; ++k) {
      if (choice_[order_[k]]) continue;
      const Absence missing = absence(order_[k], map);
      if (!missing.is_possible) return std::numeric_limits<double>::infinity();
      cost -= missing.log_chance;
    }
    return cost;
  }

  void descend(std::size_t depth, const ConstellationMap& map, double cost, int n_matched) {
    if (++n_nodes_ > kMostNodes) return;
    if (depth == order_.size()) return keep(map, cost, n_matched);
    const std::size_t i = order_[depth];
    const ConstellationTarget& target = targets_[i];
    const Prediction at = map.predicted(target.expected_mm);
    bool has_match = false;
    for (std::size_t k = 0; k < target.candidates.size(); ++k) {
      const ConstellationCandidate& c = target.candidates[k];
      if (!c.counts) continue;
      const double d2 = at.distance2(c.place_mm, c.cov_mm2);
      if (!(d2 < kGate)) continue;
      has_match = true;
      const ConstellationMap next = map.with(target.expected_mm, c.place_mm, c.cov_mm2);
      // Once the map is determined, so is what it says of the targets that were left out.
      const double absent = n_matched > 0 ? absent_cost(depth, next) : 0;
      if (cost + match_cost(d2) + absent > least_cost_ + kNegligible) continue;
      choice_[i] = k;
      descend(depth + 1, next, cost + match_cost(d2), n_matched + 1);
      choice_[i].reset();
    }
    const bool is_loose = std::sqrt(at.cov_mm2.trace()) > kLoose_mm;
    if (!has_match || is_loose) descend(depth + 1, map, cost, n_matched);
  }

  /// By the least gap of a matched score to the best of its picture. Half the margin is noise.
  double score_cost() const {
    double gap = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      if (choice_[i])
        gap = std::min(gap, best_scores_[i] - targets_[i].candidates[*choice_[i]].score);
    }
    return std::max(0.0, 2 * gap / options_.score_margin - 1) * -std::log(false_alarm_);
  }

  void keep(const ConstellationMap& map, double cost, int n_matched) {
    if (n_matched == 0) return;
    Combination out;
    out.choice = choice_;
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      const Eigen::Vector2d place_mm = map.predicted(targets_[i].expected_mm).place_mm;
      out.predicted_mm.push_back(place_mm);
      out.shift_mm += (place_mm - targets_[i].expected_mm) / static_cast<double>(targets_.size());
      Absence missing;
      if (choice_[i]) {
        missing.presence = Presence::Matched;
      } else {
        missing = absence(i, map);
      }
      if (!missing.is_possible) return;
      out.presence.push_back(missing.presence);
      cost -= missing.log_chance;
    }
    cost += out.is_complete() ? score_cost() : -std::log(kStandIn);
    if (cost > least_cost_ + kNegligible) return;
    least_cost_ = std::min(least_cost_, cost);
    out.rotation_rad = map.rotation_rad();
    out.log_weight = -cost;
    found_.push_back(std::move(out));
  }

  /// Mean over all shifts within the radius of the chance that the pictures show no target there.
  double share_outside() const {
    double radius_mm = 0;
    for (const ConstellationTarget& target : targets_) {
      if (!target.view_mm || !target.radius_mm) return 0;
      radius_mm = std::max(radius_mm, *target.radius_mm);
    }
    constexpr int kSteps = 20;
    double sum = 0;
    int n = 0;
    for (int row = -kSteps; row <= kSteps; ++row) {
      for (int column = -kSteps; column <= kSteps; ++column) {
        if (row * row + column * column > kSteps * kSteps) continue;
        const Eigen::Vector2d shift_mm = radius_mm / kSteps * Eigen::Vector2d(column, row);
        double chance = 1;
        for (const ConstellationTarget& target : targets_) {
          if (depth_mm(*target.view_mm, target.expected_mm + shift_mm) > 0) chance *= kBlank;
        }
        sum += chance;
        ++n;
      }
    }
    return sum / n;
  }

  std::span<const ConstellationTarget> targets_;
  const ConstellationOptions& options_;
  double false_alarm_;
  ConstellationMap start_;
  std::vector<std::size_t> order_;
  std::vector<double> best_scores_;
  std::vector<std::optional<std::size_t>> choice_;
  std::vector<Combination> found_;
  double least_cost_ = std::numeric_limits<double>::infinity();
  std::size_t n_nodes_ = 0;
};

}  // namespace

std::string_view name(Presence presence) {
  switch (presence) {
    case Presence::Matched:
      return "found";
    case Presence::Doubtful:
      return "covered";
    case Presence::Blank:
      return "missing";
    case Presence::Unseen:
      return "not seen";
  }
  return "not seen";
}

bool Combination::is_complete() const {
  return std::ranges::all_of(choice, [](const auto& c) { return c.has_value(); });
}

bool Constellation::is_decided() const {
  return is_exhaustive && !ranked.empty() && ranked.front().is_complete() &&
         1 - ranked.front().probability <= false_alarm;
}

Constellation assign_jointly(std::span<const ConstellationTarget> targets,
                             const ConstellationOptions& options) {
  return AssignmentSearch(targets, options).result();
}

}  // namespace panelcal
