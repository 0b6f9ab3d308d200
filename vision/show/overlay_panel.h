// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/fit/detection.h"
#include "vision/show/overlay_legend.h"
#include <opencv2/core.hpp>

namespace panelcal::internal {

/// OpenCV draws at fractions of a pixel in fixed point.
inline constexpr int kFractionBits = 8;
/// A place in fixed point; places far outside must not overflow, and are cut off anyway.
cv::Point fixed_point(double x, double y);

/// Light colours on pictures, dark ones on paper.
cv::Scalar picture_color(Ink ink);

/// The legend on paper of this width: what is said of the detection, and its uncertainty magnified.
///
/// In     width: at least 100
/// Out    8-bit BGR, as high as it has to be
cv::Mat legend_panel(const Detection& detection, const Legend& legend, int width);

}  // namespace panelcal::internal
