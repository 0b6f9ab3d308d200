// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "vision/fit/detector.h"

// Not installed.
namespace panelcal::internal {

/// Places at which a family of shapes sees its target, before any fit.
template <class Sighting>
struct Proposals {
  std::vector<Sighting> sightings;
  /// The refusal of the whole searched area, if no candidate is left; absent: there is none.
  std::optional<Judgement> if_none = {};
};

/// Of candidates nearer to each other than `apart_px` the best ones.
void keep_best(double apart_px, std::vector<FittedCandidate>& candidates);

/// A candidate that only carries a reason; it stands where one would look.
FittedCandidate refused_area(const DetectorInput& input, Judgement judgement);

/// Finds every candidate in the searched area, fits and judges it; the order does not matter.
///
/// A family of shapes has three functions:
///
///   Proposals<Sighting> propose() const      where it may be, in any order
///   Fit fit(const Sighting&) const           Fit::target: place and covariance, score, looks
///   Judgement judge(const Fit&) const        what speaks against it
///
/// It decides nothing else: candidates whose fit leaves the searched area are left out here, those
/// that ended within `apart_px` of a better one too, and locate() chooses among the rest.
template <class Family>
std::vector<FittedCandidate> detect(const DetectorInput& input,
                                    const Family& family,
                                    double apart_px = 0) {
  auto [sightings, if_none] = family.propose();
  std::vector<FittedCandidate> candidates;
  for (const auto& sighting : sightings) {
    auto fit = family.fit(sighting);
    if (!input.area.contains(fit.target.center.position.in_px(), 0)) continue;
    Judgement judgement = family.judge(fit);
    candidates.push_back({std::move(judgement), std::move(fit.target)});
  }
  if (apart_px > 0) keep_best(apart_px, candidates);
  if (candidates.empty() && if_none) candidates.push_back(refused_area(input, *if_none));
  return candidates;
}

}  // namespace panelcal::internal
