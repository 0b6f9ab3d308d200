// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "vision/fit/detection.h"
#include "vision/fit/target.h"
#include "vision/picture/image.h"

namespace panelcal {

/// A tag that was read: which one it is, and roughly where.
struct ReadTag {
  int id = 0;
  /// In the order of tag_corners(): counter-clockwise from the bottom left, as the tag stands; to
  /// about half a pixel, since nothing was fitted.
  std::array<Position<frame::Image>, 4> corners;
};

/// Reads all tags of one family in a picture, without measuring them: to learn what is seen, where
/// something else says where it is. locate() is for one tag, to hundredths of a pixel, and looks no
/// further once it sees that; this looks in every way it knows.
///
/// A mirrored tag is not read. One wrong bit is read over where chance makes no tags of that
/// (reader.h).
///
/// In     target: a tag, its size in px about that of those in the picture; its id does not matter
/// Fails  target-invalid; internal (memory)
/// Cost   7 to 21 ms for 640 x 480 px, and 0.1 ms a tag
/// See    tests/vision/tag/read_tags_test.cc
Expected<std::vector<ReadTag>> read_tags(const Image& image,
                                         const Target& target,
                                         const LocateOptions& options = {});

}  // namespace panelcal
