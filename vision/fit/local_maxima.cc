// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/local_maxima.h"

#include <algorithm>

namespace panelcal::internal {
namespace {

bool is_maximum(const cv::Mat& map, int x, int y) {
  const float v = map.at<float>(y, x);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (x + dx < 0 || y + dy < 0 || x + dx >= map.cols || y + dy >= map.rows) continue;
      const float other = map.at<float>(y + dy, x + dx);
      if (other > v || (other == v && (dy < 0 || (dy == 0 && dx < 0)))) return false;
    }
  }
  return true;
}

}  // namespace

std::vector<cv::Point> local_maxima(const cv::Mat& map, double least) {
  std::vector<cv::Point> maxima;
  for (int y = 0; y < map.rows; ++y) {
    const float* const row = map.ptr<float>(y);
    for (int x = 0; x < map.cols; ++x) {
      if (row[x] >= least && is_maximum(map, x, y)) maxima.emplace_back(x, y);
    }
  }
  std::ranges::stable_sort(
      maxima, std::ranges::greater(), [&](const cv::Point& at) { return map.at<float>(at); });
  return maxima;
}

}  // namespace panelcal::internal
