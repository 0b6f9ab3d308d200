// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "vision/picture/image.h"

namespace panelcal {

/// The largest picture that is read: 4 bytes a pixel, so 400 MB.
inline constexpr std::int64_t kMaxPicturePixels = 100'000'000;

/// Reads a PNG, TIFF, BMP or JPEG file as a grey picture.
///
/// Read are 1 to 16 bit (TIFF 1, 8, 10, 12, 14 and 16), palettes, strips and tiles, interlacing,
/// and of several pages the first. More than 8 bit end on a full scale of 65535, 10 to 14 bit of
/// TIFF scaled up to it. Numbers of 32 and 64 bit, signed or floating-point ones are refused.
///
/// Colour becomes luma, 0.299 R + 0.587 G + 0.114 B (ITU-R BT.601). Any fixed weights measure right
/// where the channels show the same place. A lens with lateral colour shifts them against each
/// other, and luma lies at their contrast-weighted mean: calibrate and measure with the same lamp
/// and mind that copper and mask differ in colour. No gamma is applied or taken back: round and
/// symmetric targets keep their middles under it, and their sizes grow or shrink.
///
/// Transparency is ignored and no orientation tag obeyed, since pixels are coordinates here. The
/// size is checked before anything is allocated, against the limit and against the file's length.
/// A damaged picture is refused, also where a decoder would fill up the rest; only damage to bare
/// levels (TIFF and BMP without compression, some of JPEG) leaves no trace in a file.
///
/// Fails  file-unreadable; picture-format; picture-too-large; picture-damaged
/// Note   a decoder's own words become part of the diagnostic
Expected<Image> read_image(const std::filesystem::path& path);

/// The same from bytes in memory; `name` stands in the diagnostics.
Expected<Image> decode_image(std::string_view bytes, std::string_view name);

/// A PNG of 8 bit for full scale 255, else of 16 bit; values are rounded and clipped.
///
/// Fails  picture-format (an empty picture)
Expected<std::string> encode_png(const Image& image);

/// A grey JPEG for people, 8 bit, levels as they are. A larger picture than max_side_px is made
/// smaller by a whole factor: means of squares of pixels; what is left at its right and lower edges
/// is cut off.
///
/// Fails  picture-format (an empty picture)
Expected<std::string> encode_jpeg(const Image& image, int max_side_px);

/// Writes the PNG whole or not at all.
///
/// Fails  picture-format; device-write
Expected<void> write_png(const std::filesystem::path& path, const Image& image);

}  // namespace panelcal
