// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/added_targets.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/base/random.h"

namespace panelcal {
namespace {

using Place = Position<frame::Nominal>;
using Choice = std::vector<std::size_t>;

/// What targets leave open is as uncertain as a measurement this weak: far below any real one, and
/// far above rounding.
constexpr double kTargetRidge = 1e-9;
constexpr int kPasses = 20;
constexpr int kStarts = 12;           ///< by chance
constexpr std::size_t kCoarse = 400;  ///< candidates while it is still far from the end
constexpr std::size_t kPairs = 150;   ///< candidates of which all pairs are tried
constexpr std::size_t kMostForPairs = 6;
/// Gains below this are rounding.
constexpr double kGain = 1e-9;
constexpr double kPower = 12;
/// A candidate this close to a target, in parts of the panel, is that target.
constexpr double kSamePlace = 1e-9;

/// How bad a design is; less is better.
struct Badness {
  double worst = std::numeric_limits<double>::infinity();
  double soft = std::numeric_limits<double>::infinity();  ///< power mean
};

enum class Goal { Worst, Soft };

bool is_better(const Badness& a, const Badness& b, Goal goal) {
  const double first_a = goal == Goal::Worst ? a.worst : a.soft;
  const double first_b = goal == Goal::Worst ? b.worst : b.soft;
  if (first_a < first_b * (1 - kGain)) return true;
  if (first_a > first_b * (1 + kGain)) return false;
  const double second_a = goal == Goal::Worst ? a.soft : a.worst;
  const double second_b = goal == Goal::Worst ? b.soft : b.worst;
  return second_a < second_b * (1 - kGain);
}

/// The problem in coordinates of the size of 1, about the middle. No model notices: each is closed
/// under moves and under scaling both frames alike.
class Search {
 public:
  explicit Search(const AdditionProblem& problem) : model_(problem.model) {
    set_frame(problem);
    fixed_.setZero();
    for (const DesignTarget& target : problem.targets) {
      fixed_ += internal::information(inside(target.nominal), target);
    }
    for (const Place& place : problem.candidates) {
      const Eigen::Vector2d p = inside(place);
      gains_.push_back(internal::information(p, {}));
      is_free_.push_back(std::ranges::none_of(problem.targets, [&](const DesignTarget& target) {
        return (inside(target.nominal) - p).norm() < kSamePlace;
      }));
    }
    for (const Place& corner : problem.corners) {
      corners_.push_back(position_mm<frame::Nominal>(inside(corner)));
    }
    base_cov_ = into_frame(problem.base_cov);
  }

  /// One after the other, each the best with those before.
  Choice greedy(std::size_t n, Goal goal) const {
    Choice chosen;
    MapCovariance sum = fixed_;
    while (chosen.size() < n) {
      const std::optional<std::size_t> next = best_next(sum, chosen, Badness(), goal, 1);
      if (!next) break;
      chosen.push_back(*next);
      sum += gains_[*next];
    }
    return chosen;
  }

  Choice best(std::size_t n) const {
    Choice best = greedy(n, Goal::Worst);
    if (best.size() < 2) return best;
    // Single exchanges end in local optima, so they start from many places; the coarse part of the
    // search sees only some of the candidates.
    const std::size_t stride = 1 + gains_.size() / kCoarse;
    std::vector<Choice> starts = {best, greedy(n, Goal::Soft)};
    Random random(1);
    for (int i = 0; i < kStarts; ++i) starts.push_back(anything(best.size(), random));
    for (Choice& start : starts) {
      exchange(start, Goal::Soft, stride);
      exchange(start, Goal::Worst, stride);
      if (is_better(badness(start), badness(best), Goal::Worst)) best = start;
    }
    exchange(best, Goal::Worst, 1);
    if (best.size() <= kMostForPairs) {
      exchange_pairs(best);
      exchange(best, Goal::Worst, 1);
    }
    return best;
  }

  /// Of one, and of the pairs that exchange_pairs goes through.
  bool tries_all(std::size_t n) const {
    return n < 2 || n >= gains_.size() || (n == 2 && gains_.size() <= kPairs);
  }

  Badness badness(std::span<const std::size_t> chosen) const {
    MapCovariance sum = fixed_;
    for (const std::size_t i : chosen) sum += gains_[i];
    return badness(sum);
  }

 private:
  void set_frame(const AdditionProblem& problem) {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Vector2d high = -low;
    const auto add = [&](const Place& p) {
      low = low.cwiseMin(p.in_mm());
      high = high.cwiseMax(p.in_mm());
    };
    for (const DesignTarget& target : problem.targets) add(target.nominal);
    for (const Place& p : problem.candidates) add(p);
    for (const Place& p : problem.corners) add(p);
    if (!low.allFinite()) return;
    middle_mm_ = (low + high) / 2;
    size_mm_ = std::max(1e-6, (high - low).maxCoeff() / 2);
  }

  Eigen::Vector2d inside(const Place& p) const { return (p.in_mm() - middle_mm_) / size_mm_; }

  /// Of coefficients that act on coordinates of the frame, with places still in mm.
  MapCovariance into_frame(const MapCovariance& cov) const {
    MapCovariance by = MapCovariance::Zero();
    for (int row = 0; row < 2; ++row) {
      by.block<2, 2>(2 * row, 2 * row) = size_mm_ * Eigen::Matrix2d::Identity();
      by.block<1, 2>(4 + row, 2 * row) = middle_mm_.transpose();
      by(4 + row, 4 + row) = 1;
    }
    return by * cov * by.transpose();
  }

  Badness badness(const MapCovariance& information) const {
    const LeverageMap map(internal::covariance_of(information, model_, base_cov_, kTargetRidge));
    Badness out{0, 0};
    for (const Place& corner : corners_) {
      const double leverage = map(corner);
      out.worst = std::max(out.worst, leverage);
      const double cube = leverage * leverage * leverage;
      out.soft += cube * cube * cube * cube;
    }
    out.soft = std::pow(out.soft, 1.0 / kPower);
    return out;
  }

  /// The candidate that is best together with `sum`, if that is better than `limit`; of every
  /// stride-th one.
  std::optional<std::size_t> best_next(const MapCovariance& sum,
                                       std::span<const std::size_t> taken,
                                       Badness limit,
                                       Goal goal,
                                       std::size_t stride) const {
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < gains_.size(); i += stride) {
      if (!is_free_[i] || std::ranges::find(taken, i) != taken.end()) continue;
      const Badness here = badness(sum + gains_[i]);
      if (!is_better(here, limit, goal)) continue;
      best = i;
      limit = here;
    }
    return best;
  }

  void exchange(Choice& chosen, Goal goal, std::size_t stride) const {
    for (int pass = 0; pass < kPasses; ++pass) {
      bool has_changed = false;
      for (std::size_t& one : chosen) {
        MapCovariance others = fixed_;
        for (const std::size_t i : chosen) {
          if (i != one) others += gains_[i];
        }
        if (const auto next = best_next(others, chosen, badness(chosen), goal, stride)) {
          one = *next;
          has_changed = true;
        }
      }
      if (!has_changed) return;
    }
  }

  /// Two at a time by any two others: out of the ends where exchanges of one are stuck.
  void exchange_pairs(Choice& chosen) const {
    const std::size_t stride = 1 + gains_.size() / kPairs;
    for (std::size_t a = 0; a < chosen.size(); ++a) {
      for (std::size_t b = a + 1; b < chosen.size(); ++b) {
        MapCovariance others = fixed_;
        for (std::size_t k = 0; k < chosen.size(); ++k) {
          if (k != a && k != b) others += gains_[chosen[k]];
        }
        Badness limit = badness(chosen);
        for (std::size_t i = 0; i < gains_.size(); i += stride) {
          if (!is_free_[i] || std::ranges::find(chosen, i) != chosen.end()) continue;
          const MapCovariance with = others + gains_[i];
          const auto next =
              best_next(with, other_than(chosen, a, b, i), limit, Goal::Worst, stride);
          if (!next) continue;
          chosen[a] = i;
          chosen[b] = *next;
          limit = badness(chosen);
        }
      }
    }
  }
  static Choice other_than(const Choice& chosen, std::size_t a, std::size_t b, std::size_t added) {
    Choice out = {added};
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      if (k != a && k != b) out.push_back(chosen[k]);
    }
    return out;
  }

  /// Precondition: at least n candidates are free.
  Choice anything(std::size_t n, Random& random) const {
    Choice chosen;
    while (chosen.size() < n) {
      const auto i =
          static_cast<std::size_t>(random.uniform() * static_cast<double>(gains_.size()));
      if (is_free_[i] && std::ranges::find(chosen, i) == chosen.end()) chosen.push_back(i);
    }
    return chosen;
  }

  PanelModel model_;
  Eigen::Vector2d middle_mm_ = Eigen::Vector2d::Zero();
  double size_mm_ = 1;
  MapCovariance fixed_;
  MapCovariance base_cov_;
  std::vector<MapCovariance> gains_;
  std::vector<bool> is_free_;
  std::vector<Place> corners_;
};

std::optional<double> worst_leverage(const AdditionProblem& problem,
                                     std::span<const std::size_t> chosen) {
  std::vector<DesignTarget> targets(problem.targets.begin(), problem.targets.end());
  for (const std::size_t i : chosen) targets.push_back({problem.candidates[i]});
  const PredictedFitResult result = predict_fit(targets, problem.model, problem.base_cov);
  if (!result.fit) return std::nullopt;
  const LeverageMap map(result.fit->cov);
  double worst = 0;
  for (const Place& corner : problem.corners) worst = std::max(worst, map(corner));
  return worst;
}

}  // namespace

Addition best_additions(const AdditionProblem& problem, std::size_t n_added) {
  Addition out;
  out.worst_before = worst_leverage(problem, {});
  const Search search(problem);
  out.chosen = search.best(n_added);
  std::ranges::sort(out.chosen);
  out.worst_after = worst_leverage(problem, out.chosen);
  out.is_best = search.tries_all(out.chosen.size());
  return out;
}

}  // namespace panelcal
