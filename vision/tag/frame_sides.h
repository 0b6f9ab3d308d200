// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "vision/picture/image.h"
#include "vision/tag/family.h"
#include "vision/tag/quads.h"

namespace panelcal::internal {

/// Moves a quad to the sides of the frame that the picture shows near it.
///
/// On each side steps of level are looked for at many places; the line that most of them agree on
/// is the side. Corners are where lines meet, so that one of them may be covered.
///
/// In     quad: no farther off than a cell
/// Out    empty if a side is not seen, or if the quad is not that of a tag in any view
/// Cost   0.2 ms
/// See    tests/vision/tag/reader_test.cc
std::optional<TagQuad> moved_to_sides(const Image& image,
                                      const TagFamily& family,
                                      const TagQuad& quad,
                                      bool is_inverted);

}  // namespace panelcal::internal
