// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>
#include <vector>

#include "vision/fit/pipeline.h"
#include "vision/tag/family.h"
#include "vision/tag/fit.h"
#include "vision/tag/search.h"

namespace panelcal::internal {
namespace {

/// AprilTags of one family.
class Tags {
 public:
  Tags(const DetectorInput& input, const TagFamily& family) : input_(input), family_(family) {}

  Proposals<TagSighting> propose() const {
    std::vector<TagSighting> sightings = search_tags(input_, family_, TagsSought::One);
    std::ranges::stable_partition(
        sightings, [&](const TagSighting& s) { return is_wanted(input_, s.reading); });
    if (sightings.size() > kMaxFittedSlow) sightings.resize(kMaxFittedSlow);
    return {std::move(sightings)};
  }
  TagFit fit(const TagSighting& sighting) const { return fit_tag(input_, family_, sighting); }
  Judgement judge(const TagFit& fit) const { return judge_tag(input_, family_, fit); }

 private:
  const DetectorInput& input_;
  const TagFamily& family_;
};

}  // namespace

std::vector<FittedCandidate> detect_tags(const DetectorInput& input) {
  const auto family = find_tag_family(input.target.tag_family);
  if (!family) return {};  // Target::validate() has said so
  return detect(input, Tags(input, *family));
}

}  // namespace panelcal::internal
