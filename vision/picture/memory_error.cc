// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/memory_error.h"

#include <new>

#include <opencv2/core.hpp>

namespace panelcal::internal {

void rethrow_memory_error(const std::exception& error) {
  const auto* const of_opencv = dynamic_cast<const cv::Exception*>(&error);
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
      (of_opencv != nullptr && of_opencv->code == cv::Error::StsNoMem)) {
    throw std::bad_alloc();
  }
}

}  // namespace panelcal::internal
