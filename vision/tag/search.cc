// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/search.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "vision/fit/frame.h"
#include "vision/tag/frame_search.h"
#include "vision/tag/quads.h"
#include "vision/tag/reader.h"

namespace panelcal::internal {
namespace {

/// Views of the library, one after the other. The first is quick and sees nearly every tag; the
/// others are there for tags much smaller or larger than asked for.
constexpr std::array kViews = {TagView{4, 0.8}, TagView{6, 1}, TagView{3, 0.5}};
/// After the first of them tags are looked for as a whole, which sees them through debris, noise
/// and blur.
constexpr int kFrameWay = 1;
constexpr int kWays = static_cast<int>(kViews.size()) + 1;
constexpr double kSameTag = 0.3;  // of the side: nearer sightings are of one tag

/// The side of the tag asked for, about, px.
double expected_side_px(const DetectorInput& input) {
  return frame_length(input.target.size, input.target.size_px, input.mapping).value_or(0);
}

Eigen::Vector2d center_of(const TagQuad& quad) {
  const Eigen::Vector3d middle = quad.image_from_tag().col(2);
  return middle.head<2>() / middle.z();
}

const TagView& view_of(int way) {
  return kViews[static_cast<std::size_t>(way > kFrameWay ? way - 1 : way)];
}

/// Reads quads and adds the tags that are new.
void add_sightings(const DetectorInput& input,
                   const TagFamily& family,
                   const std::vector<TagQuad>& quads,
                   double side_px,
                   std::vector<TagSighting>& sightings) {
  const bool is_inverted = input.target.polarity == Polarity::Dark;
  for (const TagQuad& quad : quads) {
    const Eigen::Vector2d center = center_of(quad);
    if (!input.area.contains(center, 0.1 * side_px)) continue;
    const auto reading = read_tag(input.image, family, quad, is_inverted, input.target.tag_id);
    if (!reading) continue;
    const bool is_new = std::none_of(sightings.begin(), sightings.end(), [&](const auto& s) {
      return s.reading.id == reading->id &&
             (center_of(s.quad) - center).norm() < kSameTag * quad.mean_side_px();
    });
    if (is_new) sightings.push_back({quad.turned(reading->quarters), *reading});
  }
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
  const PixelBox box = input.area.box(input.image, reach_px);
  std::vector<TagSighting> sightings;
  for (int way = 0; way < kWays; ++way) {
    const std::vector<TagQuad> quads =
        way == kFrameWay
            ? find_tag_frames(
                  input.image, box, family, {side_px, input.target.size_tolerance, is_inverted})
            : find_tag_quads(
                  input.image, box, family, cell_px, view_of(way), min_contrast, is_inverted);
    add_sightings(input, family, quads, side_px, sightings);
    const bool is_seen = std::any_of(sightings.begin(), sightings.end(), [&](const TagSighting& s) {
      return is_wanted(input, s.reading);
    });
    if (is_seen && sought == TagsSought::One) break;
  }
  return sightings;
}

}  // namespace panelcal::internal
