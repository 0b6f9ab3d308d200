// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/picture/image.h"
#include <opencv2/core.hpp>

namespace panelcal::internal {

/// The picture's own memory; not to be written to.
inline cv::Mat pixels_of(const Image& image) {
  return cv::Mat(image.height(),
                 image.width(),
                 CV_32FC1,
                 const_cast<float*>(image.pixels().data()));  // OpenCV has no const Mat
}

/// The picture rounded and clipped to 8 bit (full scale 255) or 16 bit.
inline cv::Mat mat_of(const Image& image) {
  cv::Mat mat;
  pixels_of(image).convertTo(mat, image.full_scale() > Image::kFullScale8 ? CV_16U : CV_8U);
  return mat;
}

}  // namespace panelcal::internal
