// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/files/raw_pixels.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "vision/picture/files/image_io.h"
#include "vision/picture/luma.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::array<std::pair<PixelFormat, std::string_view>, 14> kPixelFormatNames = {{
    {PixelFormat::Mono8, "Mono8"},
    {PixelFormat::Mono10, "Mono10"},
    {PixelFormat::Mono12, "Mono12"},
    {PixelFormat::Mono16, "Mono16"},
    {PixelFormat::BayerRG8, "BayerRG8"},
    {PixelFormat::BayerGR8, "BayerGR8"},
    {PixelFormat::BayerGB8, "BayerGB8"},
    {PixelFormat::BayerBG8, "BayerBG8"},
    {PixelFormat::BayerRG16, "BayerRG16"},
    {PixelFormat::BayerGR16, "BayerGR16"},
    {PixelFormat::BayerGB16, "BayerGB16"},
    {PixelFormat::BayerBG16, "BayerBG16"},
    {PixelFormat::RGB8, "RGB8"},
    {PixelFormat::BGR8, "BGR8"},
}};

tl::unexpected<Diagnostic> pixel_problem(Code code, std::string what, std::string expected) {
  return failure({code, {}, std::move(what), std::move(expected)});
}

template <class Number>
Number number_at(std::span<const std::byte> bytes, std::size_t i) {
  if constexpr (sizeof(Number) == 1) {
    return std::to_integer<Number>(bytes[i]);
  } else {
    return static_cast<Number>(std::to_integer<unsigned>(bytes[2 * i]) |
                               std::to_integer<unsigned>(bytes[2 * i + 1]) << 8U);
  }
}

template <class Number>
Image raw_image(std::span<const std::byte> bytes, int width, int height, double full_scale) {
  Image image(width, height, full_scale);
  std::size_t i = 0;
  for (float& level : image.pixels()) level = static_cast<float>(number_at<Number>(bytes, i++));
  return image;
}

Image luma_of(std::span<const std::byte> bytes, int width, int height, bool blue_first) {
  Image image(width, height, Image::kFullScale8);
  const auto value = [&](std::size_t i) {
    return static_cast<float>(std::to_integer<int>(bytes[i]));
  };
  std::size_t i = 0;
  for (float& level : image.pixels()) {
    const float first = value(i);
    const float third = value(i + 2);
    level = internal::luma(blue_first ? first : third, value(i + 1), blue_first ? third : first);
    i += 3;
  }
  return image;
}

/// 10 or 12 bit of a 16-bit container on the full scale of 16 bit.
Expected<Image> stretched(Image image, PixelFormat format) {
  const double white = format == PixelFormat::Mono10 ? 1023 : 4095;
  const std::span<float> levels = image.pixels();
  const auto largest = std::max_element(levels.begin(), levels.end());
  if (*largest > static_cast<float>(white)) {
    return pixel_problem(Code::PictureDamaged,
                         fmt::format("a level of {}", *largest),
                         fmt::format("at most {} in {}", white, name(format)));
  }
  for (float& level : levels) {
    level = static_cast<float>(Image::kFullScale16 / white * static_cast<double>(level));
  }
  return image;
}

Expected<void> check_size(std::size_t n_bytes, int width, int height, PixelFormat format) {
  if (width < 1 || height < 1) {
    return pixel_problem(Code::PictureFormat,
                         fmt::format("a picture of {} x {} pixels", width, height),
                         "at least one pixel");
  }
  if (width > kMaxPicturePixels / height) {
    return pixel_problem(Code::PictureTooLarge,
                         fmt::format("{} x {} pixels", width, height),
                         fmt::format("at most {} pixels", kMaxPicturePixels));
  }
  const std::size_t needed =
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * bytes_per_pixel(format);
  if (n_bytes < needed) {
    return pixel_problem(
        Code::PictureDamaged,
        fmt::format("{} bytes", n_bytes),
        fmt::format("{} for {} x {} pixels of {}", needed, width, height, name(format)));
  }
  return {};
}

}  // namespace

std::string_view name(PixelFormat format) {
  const auto found = std::find_if(kPixelFormatNames.begin(),
                                  kPixelFormatNames.end(),
                                  [&](const auto& entry) { return entry.first == format; });
  return found == kPixelFormatNames.end() ? std::string_view() : found->second;
}

std::optional<PixelFormat> pixel_format_from_name(std::string_view name) {
  const auto found = std::find_if(kPixelFormatNames.begin(),
                                  kPixelFormatNames.end(),
                                  [&](const auto& entry) { return entry.second == name; });
  if (found == kPixelFormatNames.end()) return std::nullopt;
  return found->first;
}

std::optional<BayerPattern> bayer_pattern(PixelFormat format) {
  switch (format) {
    case PixelFormat::BayerRG8:
    case PixelFormat::BayerRG16:
      return BayerPattern::RG;
    case PixelFormat::BayerGR8:
    case PixelFormat::BayerGR16:
      return BayerPattern::GR;
    case PixelFormat::BayerGB8:
    case PixelFormat::BayerGB16:
      return BayerPattern::GB;
    case PixelFormat::BayerBG8:
    case PixelFormat::BayerBG16:
      return BayerPattern::BG;
    default:
      return std::nullopt;
  }
}

std::size_t bytes_per_pixel(PixelFormat format) {
  switch (format) {
    case PixelFormat::Mono8:
    case PixelFormat::BayerRG8:
    case PixelFormat::BayerGR8:
    case PixelFormat::BayerGB8:
    case PixelFormat::BayerBG8:
      return 1;
    case PixelFormat::RGB8:
    case PixelFormat::BGR8:
      return 3;
    default:
      return 2;
  }
}

Expected<Image> from_raw_pixels(std::span<const std::byte> bytes,
                                int width,
                                int height,
                                PixelFormat format,
                                const ChannelGains& gains) {
  PANELCAL_CHECK(check_size(bytes.size(), width, height, format));
  PANELCAL_CHECK(gains.validate());
  if (format == PixelFormat::RGB8 || format == PixelFormat::BGR8) {
    return luma_of(bytes, width, height, format == PixelFormat::BGR8);
  }
  Image image = bytes_per_pixel(format) == 1
                    ? raw_image<std::uint8_t>(bytes, width, height, Image::kFullScale8)
                    : raw_image<std::uint16_t>(bytes, width, height, Image::kFullScale16);
  if (format == PixelFormat::Mono10 || format == PixelFormat::Mono12) {
    return stretched(std::move(image), format);
  }
  if (const auto pattern = bayer_pattern(format)) return from_bayer(image, *pattern, gains);
  return image;
}

}  // namespace panelcal
