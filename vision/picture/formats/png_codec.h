// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "vision/picture/formats/decoder.h"
#include <tl/expected.hpp>

namespace panelcal::internal {

/// Pixels in memory, top row first; samples of 16 bit in the order of this machine's bytes.
struct PngPixels {
  const unsigned char* first_row = nullptr;
  std::ptrdiff_t row_bytes = 0;
  int width = 0;
  int height = 0;
  int n_channels = 1;  ///< 1 grey, 3 blue green red
  int bits = 8;        ///< 8 or 16
};

/// The decoder of every PNG that read_plain_png() leaves.
Decoded decode_by_libpng(std::string_view bytes, const PictureHeader& header);

/// A PNG for speed: filter Sub, run lengths. The bytes depend on libpng and zlib alone.
tl::expected<std::string, std::string> encode_png_pixels(const PngPixels& pixels);

}  // namespace panelcal::internal
