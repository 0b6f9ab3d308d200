// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/detector.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "vision/tag/family.h"
#include "vision/tag/fit.h"
#include "vision/tag/search.h"

namespace panelcal::internal {
namespace {

bool is_detected_tag(const DetectorInput& input, const TagReading& reading) {
  return input.target.tag_id.value_or(reading.id) == reading.id;
}

}  // namespace

std::vector<FittedCandidate> detect_tags(const DetectorInput& input) {
  const auto family = find_tag_family(input.target.tag_family);
  if (!family) return {};  // Target::validate() has said so
  std::vector<TagSighting> sightings = search_tags(input, *family, TagsSought::One);
  std::stable_sort(sightings.begin(), sightings.end(), [&](const auto& a, const auto& b) {
    return is_detected_tag(input, a.reading) && !is_detected_tag(input, b.reading);
  });
  if (sightings.size() > kMaxFittedSlow) sightings.resize(kMaxFittedSlow);
  std::vector<FittedCandidate> candidates;
  for (const TagSighting& sighting : sightings) {
    auto candidate = fit_tag(input, *family, sighting);
    if (input.area.contains(candidate.fit.center.position.in_px(), 0)) {
      candidates.push_back(std::move(candidate));
    }
  }
  return candidates;
}

}  // namespace panelcal::internal
