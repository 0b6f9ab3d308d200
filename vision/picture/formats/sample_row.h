// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "vision/picture/luma.h"

namespace panelcal::internal {

/// Copies a row of samples, `n_channels` a pixel: 1 or 2 grey, 3 or 4 red, green and blue.
template <class Sample>
void copy_row(const Sample* samples, int n_channels, std::span<float> row) {
  for (float& level : row) {
    level = n_channels < 3 ? static_cast<float>(samples[0])
                           : luma(static_cast<float>(samples[2]),
                                  static_cast<float>(samples[1]),
                                  static_cast<float>(samples[0]));
    samples += n_channels;
  }
}

/// Grey of one byte, as OpenCV rounds it: for the few kinds of files whose colour it drops at once.
inline float rounded_luma(unsigned red, unsigned green, unsigned blue) {
  constexpr unsigned kBits = 14;
  const unsigned sum = 4899 * red + 9617 * green + 1868 * blue;
  return static_cast<float>((sum + (1U << (kBits - 1))) >> kBits);
}

}  // namespace panelcal::internal
