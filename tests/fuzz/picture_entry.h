// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "vision/picture/bayer.h"
#include "vision/picture/files/image_io.h"
#include "vision/picture/files/raw_pixels.h"
#include "vision/picture/formats/image_header.h"

namespace panelcal::fuzz {

/// Complaint about a picture that was read; empty if all is well.
inline std::optional<std::string> image_complaint(const Image& image) {
  const double full = image.full_scale();
  if (image.width() < 1 || image.height() < 1) return "a picture without pixels";
  if (full != Image::kFullScale8 && full != Image::kFullScale16) return "an unknown full scale";
  const bool is_in_range = std::ranges::all_of(image.pixels(), [&](float level) {
    return level >= 0 && level <= static_cast<float>(full);  // false for NaN
  });
  if (!is_in_range) return "a level beyond the scale";
  const auto png = encode_png(image);
  if (!png) return "cannot be written: " + png.error().text();
  const auto again = decode_image(*png, "again.png");
  if (!again) return "cannot be read again: " + again.error().text();
  const bool is_same =
      std::ranges::equal(image.pixels(), again->pixels(), [](float before, float after) {
        return std::abs(before - after) <= 0.5F;
      });
  if (again->full_scale() != full || !is_same) return "reads back as another picture";
  return std::nullopt;
}

/// Complaint about a refusal: it must be of the right kind and in one printable line.
inline std::optional<std::string> refusal_complaint(const Diagnostic& diagnostic) {
  constexpr std::array<Code, 3> kCodes = {
      Code::PictureFormat, Code::PictureTooLarge, Code::PictureDamaged};
  if (std::ranges::find(kCodes, diagnostic.code) == kCodes.end())
    return "refused as something else";
  if (diagnostic.what.empty() || diagnostic.expected.empty()) return "refused without a reason";
  const bool is_printable =
      std::ranges::all_of(diagnostic.text(), [](char c) { return c >= ' ' && c <= '~'; });
  if (!is_printable) return "refused in unprintable words";
  return std::nullopt;
}

inline std::optional<std::string> complaint_of(const Expected<Image>& read) {
  return read ? image_complaint(*read) : refusal_complaint(read.error());
}

/// The bytes as a camera's: format, width and height in the first three.
inline std::optional<std::string> run_raw_pixels(std::string_view bytes) {
  constexpr int kFormats = 14;
  if (bytes.size() < 3) return std::nullopt;
  const auto number = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  const auto format = static_cast<PixelFormat>(number(0) % kFormats);
  const auto pixels = std::as_bytes(std::span(bytes)).subspan(3);
  ChannelGains gains;
  if (const auto pattern = bayer_pattern(format)) {
    const auto even = from_raw_pixels(pixels, number(1), number(2), format);
    if (even) gains = estimated_gains(*even, *pattern);
    if (!gains.validate()) return "estimated gains that are refused";
  }
  return complaint_of(from_raw_pixels(pixels, number(1), number(2), format, gains));
}

/// Reads any bytes as a picture file, and as a camera's pixels.
///
/// Files that claim more than 4 megapixels, but not too many, are left out: they are read as all
/// others are, only slowly.
///
/// Out    what is wrong with panelcal, never with the picture; empty if all is well
inline std::optional<std::string> run_picture(std::string_view bytes) {
  constexpr std::int64_t kSlow = std::int64_t{1} << 22;
  if (auto complaint = run_raw_pixels(bytes)) return "raw pixels: " + *complaint;
  if (const auto kind = internal::picture_kind(bytes)) {
    const auto header = internal::picture_header(bytes, *kind);
    const bool is_slow = header && header->width > kSlow / header->height &&
                         header->width <= kMaxPicturePixels / header->height;
    if (is_slow) return std::nullopt;
  }
  return complaint_of(decode_image(bytes, "fuzz.picture"));
}

}  // namespace panelcal::fuzz
