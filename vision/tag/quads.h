// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "vision/fit/search_area.h"
#include "vision/picture/image.h"
#include "vision/tag/family.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// An outline of four sides that may be a tag's frame.
struct TagQuad {
  /// In the order of tag_corners(), but for a number of quarter turns; px.
  std::array<Eigen::Vector2d, 4> corners_px;

  /// Carries the tag's frame (see TagPattern) to the picture.
  Eigen::Matrix3d image_from_tag() const;
  /// The quad as it is for a tag turned by that number of quarters.
  TagQuad turned(int quarters) const;
  double mean_side_px() const;
};

/// View of a picture in which quads are searched.
struct TagView {
  /// The picture is reduced, or at least smoothed, until a cell has about this number of pixels:
  /// enough to be told from its neighbours, and few, since averaging is what makes noise harmless.
  double cell_px = 4;
  /// Sigma of the smoothing after that, reduced pixels.
  double blur_px = 0.7;
};

/// Finds all quads with a frame like that of the family's tags, readable or not.
///
/// In     box: of the picture; cell_px: a tag's cell in the picture, about; min_contrast: grey
///        levels, fainter tags need not be found; is_inverted: black and white have changed places
/// Cost   1 ms for 640 x 480 px and cells of 15 px, 5 ms for cells of 7 px
/// Source AprilTag library: Wang and Olson 2016
std::vector<TagQuad> find_tag_quads(const Image& image,
                                    const PixelBox& box,
                                    const TagFamily& family,
                                    double cell_px,
                                    const TagView& view,
                                    double min_contrast,
                                    bool is_inverted);

}  // namespace panelcal::internal
