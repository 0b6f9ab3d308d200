// SPDX-License-Identifier: Apache-2.0
#include "calib/faults/stories.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace panelcal::internal {
namespace {

// Rough shares of what goes wrong; they decide only between stories that the measurements cannot
// tell apart. Together with those of single targets and of panels laid wrongly they are about 1.
constexpr double kPriorChance = 0.02;
constexpr double kPriorNoise = 0.03;
constexpr double kPriorSofter = 0.05;
constexpr double kPriorFar = 0.03;
constexpr double kPriorMoved = 0.03;

/// Greatest distance outside the limits at which a panel is still the same panel.
constexpr double kFarOffset_mm = 100;
constexpr double kFarRotation_rad = 0.1;
constexpr double kFarStretch = 0.02;

void tell(std::span<const ToldTarget> targets,
          const PanelBelief& belief,
          double prior,
          FaultStory story,
          std::vector<FaultStory>& stories) {
  story.told = evidence(targets, belief);
  story.log_weight = story.told.log_likelihood + std::log(prior);
  stories.push_back(std::move(story));
}

std::vector<ToldTarget> with_errors(const Series& series, double factor, double sigma_mm) {
  std::vector<ToldTarget> targets(series.targets.begin(), series.targets.end());
  for (ToldTarget& target : targets) {
    target.cov_mm2 =
        factor * factor * target.cov_mm2 + sigma_mm * sigma_mm * Eigen::Matrix2d::Identity();
  }
  return targets;
}

PanelBelief far_beyond(const PanelBelief& belief) {
  return {.offset_mm = std::max(kFarOffset_mm, belief.offset_mm),
          .rotation_rad = std::max(kFarRotation_rad, belief.rotation_rad),
          .scale = std::max(kFarStretch, belief.scale),
          .difference = std::max(kFarStretch, belief.difference),
          .shear = belief.shear > 0 ? std::max(kFarStretch, belief.shear) : 0};
}

Eigen::Matrix2d matrix(double a, double b, double c, double d) {
  Eigen::Matrix2d m;
  m << a, b, c, d;
  return m;
}

}  // namespace

void tell_of_the_rest(const Series& series, std::vector<FaultStory>& stories) {
  tell(series.targets, series.belief, kPriorChance, {.kind = StoryKind::Chance}, stories);
  constexpr std::array kNoise = {1.5, 2.0, 3.0, 5.0, 8.0};
  for (const double factor : kNoise) {
    const double prior = kPriorNoise / static_cast<double>(kNoise.size());
    const FaultStory story{.kind = StoryKind::Noise};
    tell(with_errors(series, factor, 0), series.belief, prior, story, stories);
  }
  if (series.model != PanelModel::Affine) {
    const PanelBelief softer = belief_of(series.limits, PanelModel::Affine);
    tell(series.targets, softer, kPriorSofter, {.cause = FaultCause::SofterPanel}, stories);
  }
  const FaultStory far{.cause = FaultCause::WrongRevision, .kind = StoryKind::Far};
  tell(series.targets, far_beyond(series.belief), kPriorFar, far, stories);
  constexpr std::array kMoved_mm = {0.1, 0.25, 0.6, 1.5, 4.0, 10.0};
  for (const double moved_mm : kMoved_mm) {
    const double prior = kPriorMoved / static_cast<double>(kMoved_mm.size());
    const FaultStory moved{.cause = FaultCause::WrongRevision, .kind = StoryKind::Moved};
    tell(with_errors(series, 1, moved_mm), series.belief, prior, moved, stories);
  }
}

std::span<const NamedLie> named_lies() {
  using enum FaultCause;
  using enum StoryKind;
  const auto scale = [](double factor) {
    return NamedLie{WrongScale, Plain, factor, matrix(factor, 0, 0, factor), false};
  };
  static const std::array kLies = {
      NamedLie{TurnedQuarter, QuarterLeft, 1, matrix(0, -1, 1, 0), true},
      NamedLie{TurnedQuarter, QuarterRight, 1, matrix(0, 1, -1, 0), true},
      NamedLie{TurnedHalf, Plain, 1, matrix(-1, 0, 0, -1), true},
      NamedLie{Mirrored, MirroredX, 1, matrix(-1, 0, 0, 1), true},
      NamedLie{Mirrored, MirroredY, 1, matrix(1, 0, 0, -1), true},
      NamedLie{Mirrored, MirroredDiagonal, 1, matrix(0, 1, 1, 0), true},
      NamedLie{Mirrored, MirroredAntidiagonal, 1, matrix(0, -1, -1, 0), true},
      scale(25.4),
      scale(1 / 25.4),
      scale(2.54),
      scale(1 / 2.54),
      scale(0.254),
      scale(1 / 0.254),
      scale(10),
      scale(0.1),
      scale(100),
      scale(0.01),
      scale(1000),
      scale(0.001)};
  return kLies;
}

}  // namespace panelcal::internal
