// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/locate/dump.h"

#include <filesystem>
#include <stdexcept>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace panelcal::bench {

void dump_picture(const std::string& dir, const Image& image, const std::string& what, int index) {
  if (dir.empty()) return;
  cv::Mat mat(image.height(), image.width(), CV_8U);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double v = static_cast<double>(image.at(x, y)) * 255 / image.full_scale();
      mat.at<unsigned char>(y, x) = cv::saturate_cast<unsigned char>(v);
    }
  }
  std::filesystem::create_directories(dir);
  const auto file = std::filesystem::path(dir) / fmt::format("{}_{:05}.png", what, index);
  if (!cv::imwrite(file.string(), mat)) {
    throw std::runtime_error("cannot write " + file.string());
  }
}

}  // namespace panelcal::bench
