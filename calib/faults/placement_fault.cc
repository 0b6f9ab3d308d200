// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

#include "calib/base/plane_vectors.h"
#include "calib/faults/stories.h"
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

/// Rough prior of each lie; see fault_stories.cc.
constexpr double kPriorLie = 0.01;
/// A panel laid against the same pins the wrong way comes to lie so near its middle; or anywhere.
constexpr double kPinned_mm = 5;
/// Deviations of this many standard deviations are still looked for.
constexpr double kPlacementReach = 4;
/// Greatest distance of a mark that a camera sees by itself from the place that it looks at.
constexpr double kGreatestView_mm = 25;
/// Assignments of pads that are weighed for one lie; regular grids of pads give very many.
constexpr std::size_t kMostAssignments = 2000;
/// Pads whose places are all tried; of a larger panel those near the pins' place.
constexpr std::size_t kMostTried = 20'000;
/// Targets that have to be matched before the others are looked at.
constexpr std::size_t kLeastTargets = 3;

/// Pads that the search of one series looks at, repeatedly: where the noise, or limits wide open,
/// allow every pad everywhere, all ways to assign them cannot be weighed.
constexpr std::int64_t kMostLooks = 50'000'000;

using Places = std::vector<Eigen::Vector2d>;

/// The work that a search may still do.
class LookBudget {
 public:
  /// False, for ever, once too many pads were looked at.
  bool spend(std::size_t n_pads) {
    n_left_ -= static_cast<std::int64_t>(n_pads) + 1;
    return !is_spent();
  }
  bool is_spent() const { return n_left_ < 0; }

 private:
  std::int64_t n_left_ = kMostLooks;
};

/// No pad is seen as two targets.
bool are_distinct(const Places& places) {
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (places[i] == places[k]) return false;
    }
  }
  return true;
}

struct WayToLie {
  PanelBelief belief;
  Lie lie;
};

/// Laid against the pins, and anywhere.
std::array<WayToLie, 2> ways_to_lie(const Series& series, const NamedLie& named) {
  const Eigen::Vector2d center_mm = middle_mm(series);
  Lie lie{.turn = named.turn};
  if (named.is_about_center) lie.shift_mm = center_mm - named.turn * center_mm;
  PanelBelief pinned = series.belief;
  pinned.offset_mm = std::max(pinned.offset_mm, kPinned_mm);
  PanelBelief anywhere = pinned;
  double reach_mm = 0;
  for (const ToldTarget& target : series.targets) {
    reach_mm = std::max(reach_mm, (target.from_mm - center_mm).norm() + center_mm.norm());
  }
  anywhere.offset_mm = std::max(pinned.offset_mm, 2 * reach_mm * std::max(1.0, named.factor));
  return {WayToLie{pinned, lie}, WayToLie{anywhere, lie}};
}

/// Looks for the pads that the targets would be if the panel lay so.
class Matching {
 public:
  Matching(const Series& series, const NamedLie& named, const WayToLie& pinned, LookBudget& budget)
      : series_(series),
        pads_(*series.pads),
        back_(named.turn.inverse()),
        pinned_(pinned),
        budget_(budget) {
    const PanelBelief& belief = series.belief;
    rotation_ = kPlacementReach * belief.rotation_rad;
    // Scales of both directions.
    stretch_ = kPlacementReach * std::hypot(belief.scale, belief.difference) + belief.shear;
    for (const ToldTarget& target : series.targets) {
      const double variance_mm2 = target.cov_mm2.trace() / 2;
      noise_mm_ = std::max(noise_mm_, kPlacementReach * std::sqrt(2 * variance_mm2) / named.factor);
    }
    find_base();
  }

  /// Of each assignment the place of every target's pad.
  std::vector<Places> assignments() const {
    std::vector<Places> out;
    std::vector<std::size_t> firsts = first_pads();
    for (const std::size_t first : firsts) {
      follow(pads_.all()[first].place_mm, out);
      if (out.size() >= kMostAssignments || budget_.is_spent()) break;
    }
    return out;
  }

 private:
  const ToldTarget& target(std::size_t i) const { return series_.targets[i]; }
  /// Measured, relative to the first target, as it would be on the panel.
  Eigen::Vector2d arm_mm(std::size_t i) const {
    return back_ * (target(i).to_mm - target(first_).to_mm);
  }

  /// The two targets that are the farthest apart.
  void find_base() {
    double longest_mm = -1;
    for (std::size_t i = 0; i < series_.targets.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        const double length_mm = (target(i).to_mm - target(k).to_mm).norm();
        if (length_mm > longest_mm) {
          longest_mm = length_mm;
          first_ = i;
          second_ = k;
        }
      }
    }
  }

  std::vector<std::size_t> first_pads() const {
    std::vector<std::size_t> out;
    if (pads_.all().size() <= kMostTried) {
      for (std::size_t i = 0; i < pads_.all().size(); ++i) out.push_back(i);
      return out;
    }
    const Eigen::Vector2d middle = back_ * (target(first_).to_mm - pinned_.lie.shift_mm);
    const double scale = std::abs(back_(0, 0)) + std::abs(back_(0, 1));
    const Eigen::Vector2d reach = Eigen::Vector2d::Constant(
        scale * kPlacementReach * pinned_.belief.offset_mm + rotation_ * pads_.box_diagonal_mm());
    pads_.inside(middle - reach, middle + reach, out);
    return out;
  }

  void follow(const Eigen::Vector2d& first_mm, std::vector<Places>& out) const {
    const Eigen::Vector2d arm = arm_mm(second_);
    const double length_mm = arm.norm();
    if (!(length_mm > 0)) return;
    const Eigen::Vector2d along = arm / length_mm;
    const Eigen::Vector2d across(-along.y(), along.x());
    const double along_mm = stretch_ * length_mm + noise_mm_;
    const double across_mm = rotation_ * length_mm + along_mm;
    const Eigen::Vector2d reach = along.cwiseAbs() * along_mm + across.cwiseAbs() * across_mm;
    std::vector<std::size_t> seconds;
    pads_.inside(first_mm + arm - reach, first_mm + arm + reach, seconds);
    if (!budget_.spend(seconds.size())) return;
    for (const std::size_t i : seconds) {
      if (pads_.all()[i].place_mm == first_mm) continue;
      const Eigen::Vector2d off = pads_.all()[i].place_mm - first_mm - arm;
      if (std::abs(off.dot(along)) > along_mm || std::abs(off.dot(across)) > across_mm) continue;
      complete(first_mm, pads_.all()[i].place_mm, out);
      if (out.size() >= kMostAssignments || budget_.is_spent()) return;
    }
  }

  /// With two pads given the rotation is known, and the others' places but for the stretch.
  void complete(const Eigen::Vector2d& first_mm,
                const Eigen::Vector2d& second_mm,
                std::vector<Places>& out) const {
    const Eigen::Vector2d is = second_mm - first_mm;
    const Eigen::Vector2d was = arm_mm(second_);
    const double angle = std::atan2(cross(was, is), was.dot(is));
    Eigen::Matrix2d r;
    r << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    Places places(series_.targets.size());
    places[first_] = first_mm;
    places[second_] = second_mm;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (i == first_ || i == second_) continue;
      const Eigen::Vector2d arm = r * arm_mm(i);
      const double reach_mm = 2 * (stretch_ * std::max(arm.norm(), is.norm()) + noise_mm_);
      const std::vector<std::size_t> near = pads_.within(first_mm + arm, reach_mm);
      if (!budget_.spend(near.size()) || near.empty()) return;
      places[i] = pads_.all()[near.front()].place_mm;
    }
    if (!are_distinct(places)) return;
    out.push_back(std::move(places));
  }

  const Series& series_;
  const KnownPads& pads_;
  Eigen::Matrix2d back_;  ///< to the panel, without shift
  const WayToLie& pinned_;
  LookBudget& budget_;
  double rotation_ = 0;
  double stretch_ = 0;
  double noise_mm_ = 0;
  std::size_t first_ = 0;
  std::size_t second_ = 0;
};

/// Number of pads; unlike KnownPads::within it does not sort what may be all of them.
std::size_t count_within(const KnownPads& pads,
                         const Eigen::Vector2d& place_mm,
                         double radius_mm,
                         std::vector<std::size_t>& buffer) {
  const Eigen::Vector2d reach_mm = Eigen::Vector2d::Constant(radius_mm);
  pads.inside(place_mm - reach_mm, place_mm + reach_mm, buffer);
  return static_cast<std::size_t>(std::ranges::count_if(buffer, [&](std::size_t i) {
    return (pads.all()[i].place_mm - place_mm).norm() <= radius_mm;
  }));
}

/// The chance that a camera takes these pads: the nearest to where it looks half of the time, the
/// next one a quarter, and so on.
double log_chance_taken(const Series& series,
                        const Evidence& told,
                        std::span<const ToldTarget> seen,
                        LookBudget& budget) {
  const Eigen::Matrix2d back = told.linear.inverse();
  double n_passed_over = 0;
  std::vector<std::size_t> buffer;
  for (std::size_t i = 0; i < seen.size() && budget.spend(buffer.size()); ++i) {
    const Eigen::Vector2d looked_at = back * (series.targets[i].from_mm - told.translation_mm);
    const double distance_mm = (seen[i].from_mm - looked_at).norm();
    n_passed_over += static_cast<double>(
        count_within(*series.pads, looked_at, distance_mm * (1 - 1e-9), buffer));
  }
  return -(n_passed_over + static_cast<double>(seen.size())) * std::numbers::ln2;
}

void weigh(const Series& series,
           const NamedLie& named,
           const Places& places,
           const WayToLie& way,
           LookBudget& budget,
           std::vector<FaultStory>& stories) {
  std::vector<ToldTarget> seen(series.targets.begin(), series.targets.end());
  for (std::size_t i = 0; i < seen.size(); ++i) seen[i].from_mm = places[i];
  FaultStory story{.cause = named.cause, .kind = named.kind, .factor = named.factor};
  story.told = evidence(seen, way.belief, way.lie);
  story.log_weight = story.told.log_likelihood +
                     log_chance_taken(series, story.told, seen, budget) + std::log(kPriorLie / 2);
  stories.push_back(story);
}

/// The camera did not take slots and targets far from where it looked by itself.
bool may_be_taken(const Series& series) {
  if (series.pads == nullptr || series.targets.size() < kLeastTargets) return false;
  return std::ranges::all_of(series.targets, [](const ToldTarget& target) {
    return target.axes == ObservedAxes::Both &&
           (target.to_mm - target.from_mm).norm() < kGreatestView_mm;
  });
}

}  // namespace

Eigen::Vector2d middle_mm(const Series& series) {
  if (series.pads != nullptr && !series.pads->all().empty()) return series.pads->box_center_mm();
  constexpr double kHuge = std::numeric_limits<double>::infinity();
  Eigen::Vector2d low_mm = Eigen::Vector2d::Constant(kHuge);
  Eigen::Vector2d high_mm = Eigen::Vector2d::Constant(-kHuge);
  for (const ToldTarget& target : series.targets) {
    low_mm = low_mm.cwiseMin(target.from_mm);
    high_mm = high_mm.cwiseMax(target.from_mm);
  }
  return 0.5 * (low_mm + high_mm);
}

void tell_of_lies(const Series& series, std::vector<FaultStory>& stories) {
  for (const NamedLie& named : named_lies()) {
    for (const WayToLie& way : ways_to_lie(series, named)) {
      FaultStory story{.cause = named.cause, .kind = named.kind, .factor = named.factor};
      story.told = evidence(series.targets, way.belief, way.lie);
      story.log_weight = story.told.log_likelihood + std::log(kPriorLie / 4);
      stories.push_back(story);
    }
  }
}

bool tell_of_taken_pads(const Series& series, std::vector<FaultStory>& stories) {
  if (!may_be_taken(series)) return true;
  const std::size_t n_before = stories.size();
  LookBudget budget;
  for (const NamedLie& named : named_lies()) {
    const std::array<WayToLie, 2> ways = ways_to_lie(series, named);
    const Matching matching(series, named, ways[0], budget);
    for (const Places& places : matching.assignments()) {
      for (const WayToLie& way : ways) weigh(series, named, places, way, budget, stories);
    }
    if (!budget.is_spent()) continue;
    // A part of them would weigh against causes that were not looked at.
    stories.resize(n_before);
    return false;
  }
  return true;
}

}  // namespace panelcal::internal
