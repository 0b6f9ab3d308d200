// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/expected.h"
#include "vision/picture/image.h"
#include <opencv2/core.hpp>

namespace panelcal::internal {

/// The picture rounded and clipped to 8 bit (full scale 255) or 16 bit.
cv::Mat mat_of(const Image& image);

/// Encodes any 8- or 16-bit Mat as PNG.
Expected<std::string> png_of(const cv::Mat& mat);

}  // namespace panelcal::internal
