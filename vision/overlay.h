// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "panelcal/calib/base/expected.h"
#include "panelcal/calib/base/units.h"
#include "panelcal/vision/image.h"
#include "panelcal/vision/locate.h"

namespace panelcal {

struct OverlayOptions {
  /// Half the side of the piece of picture that is shown; absent: the target and half its size
  /// around it, or the whole picture if nothing was found.
  std::optional<PixelLength> half_width;
  int min_side =
      320;  ///< small pieces are scaled up by a whole number to at least this many pixels
};

/// A colour PNG of the picture around the detection, with what was found drawn in: the best
/// candidate's rim and centre (green if found, red if not) and the others' rims (yellow).
///
/// Fails  picture-format (an empty picture)
Expected<std::string> encode_overlay(const Image& image,
                                     const Detection& detection,
                                     const OverlayOptions& options = {});

}  // namespace panelcal
