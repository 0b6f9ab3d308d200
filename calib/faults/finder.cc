// SPDX-License-Identifier: Apache-2.0
#include "calib/faults/finder.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/base/statistics/chi_square.h"
#include "calib/faults/stories.h"
#include "calib/faults/words.h"

namespace panelcal::internal {
namespace {

/// Suspicions are listed until this much of the probability is, but at most this number.
constexpr double kListed = 0.99;
constexpr std::size_t kMostListed = 6;

/// One cause with everything that was told of it.
struct Cause {
  FaultStory best;
  double probability = 0;
};

bool is_same_cause(const FaultStory& a, const FaultStory& b) {
  const bool same_pad =
      a.pad.has_value() == b.pad.has_value() && (!a.pad || a.pad->place_mm == b.pad->place_mm);
  return a.cause == b.cause && a.kind == b.kind && a.i_point == b.i_point && a.factor == b.factor &&
         same_pad;
}

/// Posterior probabilities, the likeliest cause first.
std::vector<Cause> weighed(const std::vector<FaultStory>& stories) {
  double greatest = -std::numeric_limits<double>::infinity();
  for (const FaultStory& story : stories) greatest = std::max(greatest, story.log_weight);
  std::vector<Cause> causes;
  if (!std::isfinite(greatest)) return causes;
  double sum = 0;
  for (const FaultStory& story : stories) {
    const double weight = std::exp(story.log_weight - greatest);
    sum += weight;
    // A term too small to be listed needs no place in the list.
    if (weight < 1e-12) continue;
    const auto known = std::ranges::find_if(
        causes, [&](const Cause& cause) { return is_same_cause(cause.best, story); });
    if (known == causes.end()) {
      causes.push_back({story, weight});
      continue;
    }
    known->probability += weight;
    if (story.log_weight > known->best.log_weight) known->best = story;
  }
  for (Cause& cause : causes) cause.probability /= sum;
  std::ranges::stable_sort(causes, std::ranges::greater{}, &Cause::probability);
  return causes;
}

std::optional<std::size_t> outlier_of(const std::vector<Cause>& causes, std::size_t n) {
  std::vector<double> by_point(n, 0);
  for (const Cause& cause : causes) {
    if (cause.best.i_point) by_point[*cause.best.i_point] += cause.probability;
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (by_point[i] > SeriesFault::kNamed) return i;
  }
  return std::nullopt;
}

struct Told {
  std::vector<FaultStory> stories;
  bool weighs_taken_pads = false;
};

Told told_of(const Series& series) {
  Told told;
  std::vector<FaultStory>& stories = told.stories;
  tell_of_the_rest(series, stories);
  tell_of_liars(series, stories);
  tell_of_lies(series, stories);
  told.weighs_taken_pads = tell_of_taken_pads(series, stories);
  return told;
}

}  // namespace

std::optional<SeriesFault> find_fault_raw(std::span<const ExaminedTarget> targets,
                                          PanelModel model,
                                          const FaultContext& context) {
  std::vector<RawPair> pairs;
  std::vector<ToldTarget> told;
  std::vector<PictureFacts> facts;
  for (const ExaminedTarget& target : targets) {
    pairs.push_back({target.from_mm, target.to_mm, target.cov_mm2, target.axes});
    told.push_back({target.from_mm, target.to_mm, target.cov_mm2, target.axes});
    ToldTarget picture = told.back();
    picture.cov_mm2 = target.picture_cov_mm2.value_or(target.cov_mm2);
    facts.push_back({target.score, sigma_mm_of(picture)});
  }
  const RawFitResult result = fit_raw(pairs, model);
  if (!result.fit) return std::nullopt;
  SeriesFault fault;
  fault.degrees_of_freedom = result.fit->degrees_of_freedom;
  fault.false_alarm = context.limits.false_alarm.value_or(0);
  if (fault.degrees_of_freedom > 0) {
    fault.p_value = chi_square_exceedance(result.fit->chi_square, fault.degrees_of_freedom);
  }
  // Written so that a NaN is refused.
  const bool is_rejected = fault.false_alarm > 0 && !(fault.p_value >= fault.false_alarm);
  if (!is_rejected && !context.is_refused) return std::nullopt;

  const Series series{
      told, facts, model, context.limits, belief_of(context.limits, model), context.pads};
  const Told all = told_of(series);
  fault.weighs_taken_pads = all.weighs_taken_pads;
  const std::vector<Cause> causes = weighed(all.stories);
  double listed = 0;
  for (const Cause& cause : causes) {
    if (listed >= kListed || fault.suspicions.size() >= kMostListed) break;
    listed += cause.probability;
    fault.suspicions.push_back({cause.best.cause,
                                cause.best.i_point,
                                cause.probability,
                                words_of(cause.best, series, targets)});
  }
  if (fault.suspicions.empty()) fault.suspicions.push_back({{}, {}, 1, "no cause is known"});
  if (fault.weighs_taken_pads) fault.i_outlier = outlier_of(causes, targets.size());
  return fault;
}

}  // namespace panelcal::internal
