// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/search.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "vision/fit/frame.h"
#include "vision/tag/quads.h"
#include "vision/tag/reader.h"

namespace panelcal::internal {
namespace {

/// One after the other. The first is quick and sees nearly every tag; the others are there for tags
/// much smaller or larger than asked for, blur and debris.
constexpr std::array kViews = {TagView{4, 0.8}, TagView{6, 1}, TagView{3, 0.5}};
constexpr double kSameTag = 0.3;  // of the side: nearer sightings are of one tag

/// The side of the tag asked for, about, px.
double expected_side_px(const DetectorInput& input) {
  return frame_length(input.target.size, input.target.size_px, input.mapping).value_or(0);
}

bool is_searched_tag(const DetectorInput& input, const TagReading& reading) {
  return input.target.tag_id.value_or(reading.id) == reading.id;
}

Eigen::Vector2d center_of(const TagQuad& quad) {
  const Eigen::Vector3d middle = quad.image_from_tag().col(2);
  return middle.head<2>() / middle.z();
}

}  // namespace

std::vector<TagSighting> search_tags(const DetectorInput& input,
                                     const TagFamily& family,
                                     TagsSought sought) {
  const double side_px = expected_side_px(input);
  const double cell_px = side_px / family.n_on_side;
  // A tag reaches beyond its corners' square, and may lie askew.
  const double reach_px = side_px * std::sqrt(0.5) * (family.n_cells + 2) / family.n_on_side + 4;
  const bool is_inverted = input.target.polarity == Polarity::Dark;
  const double min_contrast = input.options.min_contrast * input.image.full_scale();
  std::vector<TagSighting> sightings;
  for (const TagView& view : kViews) {
    for (const TagQuad& quad : find_tag_quads(input.image,
                                              input.area.box(input.image, reach_px),
                                              family,
                                              cell_px,
                                              view,
                                              min_contrast,
                                              is_inverted)) {
      const Eigen::Vector2d center = center_of(quad);
      if (!input.area.contains(center, 0.1 * side_px)) continue;
      const auto reading = read_tag(input.image, family, quad, is_inverted);
      if (!reading) continue;
      const bool is_new = std::none_of(sightings.begin(), sightings.end(), [&](const auto& s) {
        return s.reading.id == reading->id &&
               (center_of(s.quad) - center).norm() < kSameTag * quad.mean_side_px();
      });
      if (is_new) sightings.push_back({quad.turned(reading->quarters), *reading});
    }
    if (sought == TagsSought::All) continue;
    if (std::any_of(sightings.begin(), sightings.end(), [&](const TagSighting& s) {
          return is_searched_tag(input, s.reading);
        })) {
      break;
    }
  }
  return sightings;
}

}  // namespace panelcal::internal
