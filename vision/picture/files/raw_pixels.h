// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "calib/base/expected.h"
#include "vision/picture/bayer.h"
#include "vision/picture/image.h"

namespace panelcal {

/// Layout of a camera's numbers in memory, row after row without gaps.
///
/// Names and meaning are the GenICam pixel format naming convention's; 10, 12 and 16 bit stand in
/// 16-bit containers, low byte first, the number at the low end.
enum class PixelFormat {
  Mono8,
  Mono10,
  Mono12,
  Mono16,
  BayerRG8,
  BayerGR8,
  BayerGB8,
  BayerBG8,
  BayerRG16,
  BayerGR16,
  BayerGB16,
  BayerBG16,
  RGB8,
  BGR8,
};

std::string_view name(PixelFormat format);  ///< "Mono8" and so on
std::optional<PixelFormat> pixel_format_from_name(std::string_view name);
std::optional<BayerPattern> bayer_pattern(PixelFormat format);  ///< empty if there is none
std::size_t bytes_per_pixel(PixelFormat format);

/// A picture from a camera's bytes. Mono10 and Mono12 are scaled up to 65535, so that saturation
/// is full scale; RGB8 and BGR8 become luma as colour files do (see image_io.h); Bayer formats
/// go through from_bayer.
///
/// In     bytes: width * height * bytes_per_pixel, or more (cameras pad and append)
/// Fails  picture-format (a size below 1, invalid gains); picture-too-large; picture-damaged
///        (fewer bytes, or numbers above 10 or 12 bit)
Expected<Image> from_raw_pixels(std::span<const std::byte> bytes,
                                int width,
                                int height,
                                PixelFormat format,
                                const ChannelGains& gains = {});

}  // namespace panelcal
