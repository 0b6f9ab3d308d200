// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/fit/detector.h"
#include "vision/tag/family.h"
#include "vision/tag/fit.h"

namespace panelcal::internal {

/// Criterion to end the search.
enum class TagsSought {
  One,  ///< once a tag of the target's id is seen, or any tag if it has none
  All,  ///< never: what one way of looking misses another one may see
};

/// Finds and reads the tags of a family, whatever their ids, before any fit. The picture is looked
/// at in up to four ways.
///
/// In     input: of a tag of about that size
/// Cost   1 to 15 ms for 640 x 480 px where the first look sees a tag; else that of
///        find_tag_frames() on top
std::vector<TagSighting> search_tags(const DetectorInput& input,
                                     const TagFamily& family,
                                     TagsSought sought);

}  // namespace panelcal::internal
