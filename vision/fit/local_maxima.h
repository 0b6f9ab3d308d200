// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <opencv2/core.hpp>

// Not installed.
namespace panelcal::internal {

/// Places of a map of floats that are `least` at least and no lower than their eight neighbours,
/// the highest first; of equal neighbours the first one of the first row counts.
std::vector<cv::Point> local_maxima(const cv::Mat& map, double least);

}  // namespace panelcal::internal
