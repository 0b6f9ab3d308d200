// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/read_tags.h"

#include <cstddef>
#include <exception>
#include <string>

#include "vision/fit/detector.h"
#include "vision/picture/memory_error.h"
#include "vision/tag/family.h"
#include "vision/tag/search.h"

namespace panelcal {
namespace {

std::vector<ReadTag> read_checked(const Image& image,
                                  const Target& target,
                                  const TagFamily& family,
                                  const LocateOptions& options) {
  const internal::DetectorInput input{
      image, target, nullptr, options, internal::SearchArea(options)};
  std::vector<ReadTag> tags;
  for (const internal::TagSighting& sighting :
       internal::search_tags(input, family, internal::TagsSought::All)) {
    ReadTag& tag = tags.emplace_back();
    tag.id = sighting.reading.id;
    for (std::size_t i = 0; i < tag.corners.size(); ++i) {
      tag.corners[i] = position_px<frame::Image>(sighting.quad.corners_px[i]);
    }
  }
  return tags;
}

}  // namespace

Expected<std::vector<ReadTag>> read_tags(const Image& image,
                                         const Target& target,
                                         const LocateOptions& options) {
  PANELCAL_CHECK(target.validate());
  PANELCAL_CHECK(options.validate());
  if (target.shape != Shape::AprilTag || !target.size_px) {
    return failure({Code::TargetInvalid, {}, "no tag with a size in px", "an AprilTag, size_px"});
  }
  const auto family = find_tag_family(target.tag_family);
  if (!family) {
    return failure({Code::TargetInvalid,
                    {},
                    "no family " + quoted(target.tag_family),
                    "a family of the AprilTag library, such as tag36h11"});
  }
  Target any = target;
  any.tag_id.reset();
  try {
    return read_checked(image, any, *family, options);
  } catch (const std::exception& e) {
    internal::rethrow_memory_error(e);
    return failure({Code::Internal, {}, std::string("reading tags: ") + e.what(), ""});
  }
}

}  // namespace panelcal
