// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "vision/picture/image.h"
#include <opencv2/imgcodecs.hpp>

namespace panelcal::test {

/// A picture with structure in 8 or 16 bit.
inline Image sample(double full_scale) {
  Image image(23, 17, full_scale);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      image.at(x, y) = static_cast<float>((x * 11 + y * 5 + x * y) % 256);
      if (full_scale > 255) image.at(x, y) = image.at(x, y) * 257;
    }
  }
  return image;
}

inline cv::Mat mat_of_sample(int type) {
  cv::Mat mat(17, 23, type);
  cv::randu(mat, 0, CV_MAT_DEPTH(type) == CV_16U ? 65535 : 255);
  return mat;
}

inline std::string encoded(const cv::Mat& mat, const char* extension) {
  std::vector<unsigned char> bytes;
  cv::imencode(extension, mat, bytes);
  return std::string(bytes.begin(), bytes.end());
}

}  // namespace panelcal::test
