// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/fit/search_area.h"
#include "vision/picture/image.h"
#include "vision/tag/family.h"
#include "vision/tag/quads.h"

namespace panelcal::internal {

/// The size and look of the tags that a frame search is for.
struct FrameQuery {
  double side_px = 0;         ///< of the corners' square, about
  double size_tolerance = 0;  ///< relative
  bool is_inverted = false;   ///< black and white have changed places
};

/// Finds places where the picture is bright and dark as a tag's frame is, in any turn, whatever
/// hides a part of it: where contours are torn by debris and noise, sums over the whole frame still
/// stand out.
///
/// For every place of a reduced picture (two pixels a cell), turn and size the mean of the frame's
/// outer cells less that of its inner ones, over the spread of the levels there, is a score; its
/// highest local maxima are brought to the sides that the full picture shows (frame_sides.h).
///
/// Out    the likeliest first, at most 16
/// Cost   640 x 480 px, cells of 15 and of 3 px: 10 and 57 ms; with a size tolerance of 0.2, 18 and
///        300 ms
/// See    tests/vision/tag/reader_test.cc
std::vector<TagQuad> find_tag_frames(const Image& image,
                                     const PixelBox& box,
                                     const TagFamily& family,
                                     const FrameQuery& query);

}  // namespace panelcal::internal
