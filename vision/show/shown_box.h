// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/base/units.h"
#include "vision/fit/detection.h"
#include "vision/picture/image.h"
#include <opencv2/core/types.hpp>

// Not installed.
namespace panelcal::internal {

/// The piece of a picture that shows all that matters: the best candidate and others that count, or
/// the whole picture where nothing was found.
cv::Rect shown_box(const Image& image,
                   const Detection& detection,
                   std::optional<PixelLength> half_width = {});

}  // namespace panelcal::internal
