// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "vision/picture/formats/image_header.h"
#include "vision/picture/formats/tiff_directory.h"
#include "vision/picture/image.h"
#include <tl/expected.hpp>

namespace panelcal::internal {

/// A whole picture, or the decoder's words about its damage.
using Decoded = tl::expected<Image, std::string>;

// One decoder a format: each on the format's own library (libpng, libjpeg, libtiff; BMP needs
// none). Pixels come as they stand in the file: no gamma, no orientation. Colour becomes luma,
// transparency is ignored. A decoder that would go on after damage with made-up pixels says so in
// its warnings: these refuse the picture.
//
// In     a header that was checked: its size is what gets allocated
// See    tests/vision/picture/formats/decoder_test.cc compares each with OpenCV's, pixel by pixel

Decoded decode_png(std::string_view bytes, const PictureHeader& header);

/// CMYK becomes RGB without a profile: c' = k - (255 - c) k / 256.
Decoded decode_jpeg(std::string_view bytes, const PictureHeader& header);

/// 1, 4 and 8 bit with palette, 16 (5-5-5 and 5-6-5), 24 and 32 bit; run lengths of 4 and 8 bit.
Decoded decode_bmp(std::string_view bytes, const PictureHeader& header);

/// Numbers of 10 to 14 bit are shifted up to 16; finish_levels makes white of them.
Decoded decode_tiff(std::string_view bytes,
                    const PictureHeader& header,
                    const TiffDirectory& directory);

}  // namespace panelcal::internal
