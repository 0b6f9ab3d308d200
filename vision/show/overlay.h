// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "vision/fit/detection.h"
#include "vision/picture/image.h"
#include "vision/show/other_candidates.h"

namespace panelcal {

struct OverlayOptions {
  /// Half the side of the piece of picture that is shown; absent: the target and half its size
  /// around it, with every other candidate that counts, or the whole picture if nothing was found.
  std::optional<PixelLength> half_width = {};
  /// Small pieces are scaled up by a whole number to at least this many pixels, 1 to 4096.
  int min_side = 400;
  /// Under the picture, in words: what was found and how well, and why other places do not count;
  /// beside it the uncertainty, magnified. Without it only the picture is shown.
  bool with_legend = true;
  std::string title = {};  ///< first line of the legend; ASCII
  /// Area in which the target was searched (see LocateOptions); drawn if both are there.
  std::optional<Position<frame::Image>> search_center = {};
  std::optional<PixelLength> search_radius = {};
};

/// A colour PNG of the picture around the detection, with what was found drawn in.
///
/// The best candidate's outlines and centre are green if found and red if not; other candidates'
/// outlines are yellow, with their numbers. The inset shows the ellipse that holds the true centre
/// in 95 of 100 pictures; for slots, whose place along themselves is not known, the strip.
///
/// In     any detection; places far outside of the picture and numbers that are not finite are not
///        drawn
/// Fails  picture-format (an empty picture)
/// Cost   about 6 ms for 400 x 400 px with the legend
/// See    tests/vision/show/overlay_test.cc
Expected<std::string> encode_overlay(const Image& image,
                                     const Detection& detection,
                                     const OverlayOptions& options = {});

}  // namespace panelcal
