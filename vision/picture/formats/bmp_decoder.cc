// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>

#include "vision/picture/formats/byte_reader.h"
#include "vision/picture/formats/decoder.h"
#include "vision/picture/formats/sample_row.h"

namespace panelcal::internal {
namespace {

enum BmpCompression : std::uint32_t { kBmpNone = 0, kBmpRuns8 = 1, kBmpRuns4 = 2, kBmpMasks = 3 };

constexpr std::size_t kBmpHeaderAt = 14;
constexpr std::uint32_t kBmpCoreHeader = 12;
/// BITMAPINFOHEADER; later ones are longer and begin alike.
constexpr std::uint32_t kBmpInfoHeader = 40;

struct BmpFile {
  ByteReader in;
  int width = 0;
  int height = 0;
  bool is_top_first = false;
  std::uint32_t bits = 0;
  std::uint32_t compression = kBmpNone;
  bool has_six_green_bits = false;  ///< 16 bit: 5-6-5, not 5-5-5
  bool is_rounded = false;
  std::size_t pixels_at = 0;
  std::array<float, 256> palette{};

  std::span<float> row(Image& image, int i) const {
    return image.row(is_top_first ? i : height - 1 - i);
  }
};

bool read_bmp_palette(BmpFile& file, std::size_t at, std::size_t n_colors, std::size_t n_bytes) {
  if (n_colors > file.palette.size()) return false;
  for (std::size_t i = 0; i < n_colors; ++i, at += n_bytes) {
    const auto blue = file.in.u8(at);
    const auto green = file.in.u8(at + 1);
    const auto red = file.in.u8(at + 2);
    if (!red || !file.in.u8(at + n_bytes - 1)) return false;
    file.palette[i] =
        file.is_rounded
            ? rounded_luma(*red, *green, *blue)
            : luma(static_cast<float>(*blue), static_cast<float>(*green), static_cast<float>(*red));
  }
  return true;
}

/// The masks of red, green and blue that occur: others would be read as other colours.
bool read_bmp_masks(BmpFile& file) {
  const auto red = file.in.u32(kBmpHeaderAt + kBmpInfoHeader);
  const auto green = file.in.u32(kBmpHeaderAt + kBmpInfoHeader + 4);
  const auto blue = file.in.u32(kBmpHeaderAt + kBmpInfoHeader + 8);
  if (!red || !green || !blue) return false;
  if (file.bits == 32) return *red == 0xFF0000 && *green == 0xFF00 && *blue == 0xFF;
  file.has_six_green_bits = *green == 0x7E0;
  return *blue == 0x1F &&
         (file.has_six_green_bits ? *red == 0xF800 : *green == 0x3E0 && *red == 0x7C00);
}

bool is_known_bmp(std::uint32_t bits, std::uint32_t compression) {
  if (compression == kBmpRuns8) return bits == 8;
  if (compression == kBmpRuns4) return bits == 4;
  if (compression == kBmpMasks) return bits == 16 || bits == 32;
  return compression == kBmpNone &&
         (bits == 1 || bits == 4 || bits == 8 || bits == 16 || bits == 24 || bits == 32);
}

std::optional<BmpFile> bmp_file(std::string_view bytes, const PictureHeader& header) {
  BmpFile file{.in = ByteReader(bytes, false)};
  file.width = static_cast<int>(header.width);
  file.height = static_cast<int>(header.height);
  const auto pixels_at = file.in.u32(10);
  const auto header_size = file.in.u32(kBmpHeaderAt);
  if (!pixels_at || !header_size) return std::nullopt;
  file.pixels_at = *pixels_at;
  const bool is_core = *header_size == kBmpCoreHeader;
  if (!is_core && *header_size < kBmpInfoHeader) return std::nullopt;
  const auto bits = file.in.u16(kBmpHeaderAt + (is_core ? 10 : 14));
  const auto compression =
      is_core ? std::optional<std::uint32_t>(kBmpNone) : file.in.u32(kBmpHeaderAt + 16);
  if (!bits || !compression || !is_known_bmp(*bits, *compression)) return std::nullopt;
  if (is_core && *bits == 16) return std::nullopt;
  file.bits = *bits;
  file.compression = *compression;
  file.is_rounded = is_core;
  if (!is_core) {
    file.is_top_first = static_cast<std::int32_t>(file.in.u32(kBmpHeaderAt + 8).value_or(0)) < 0;
  }
  if (file.compression == kBmpMasks && !read_bmp_masks(file)) return std::nullopt;
  if (file.bits <= 8) {
    const std::uint32_t n_told = is_core ? 0 : file.in.u32(kBmpHeaderAt + 32).value_or(0);
    const std::size_t n_colors = n_told == 0 ? std::size_t{1} << file.bits : n_told;
    const std::size_t at = kBmpHeaderAt + *header_size;
    if (!read_bmp_palette(file, at, n_colors, is_core ? 3 : 4)) return std::nullopt;
  }
  return file;
}

float bmp_level(const BmpFile& file, std::size_t row_at, std::size_t x) {
  if (file.bits <= 8) {
    const std::size_t bit = x * file.bits;
    const std::uint32_t byte = file.in.u8(row_at + bit / 8).value_or(0);
    return file.palette[byte >> (8 - file.bits - bit % 8) & ((1U << file.bits) - 1)];
  }
  std::uint32_t blue = 0;
  std::uint32_t green = 0;
  std::uint32_t red = 0;
  if (file.bits == 16) {
    const std::uint32_t word = file.in.u16(row_at + 2 * x).value_or(0);
    blue = (word & 0x1F) << 3;
    green = file.has_six_green_bits ? (word >> 3) & 0xFC : (word >> 2) & 0xF8;
    red = file.has_six_green_bits ? (word >> 8) & 0xF8 : (word >> 7) & 0xF8;
  } else {
    const std::size_t at = row_at + x * (file.bits / 8);
    blue = file.in.u8(at).value_or(0);
    green = file.in.u8(at + 1).value_or(0);
    red = file.in.u8(at + 2).value_or(0);
  }
  return file.is_rounded
             ? rounded_luma(red, green, blue)
             : luma(static_cast<float>(blue), static_cast<float>(green), static_cast<float>(red));
}

bool read_bmp_rows(const BmpFile& file, Image& image) {
  const std::size_t row_bytes =
      (static_cast<std::size_t>(file.width) * file.bits + 31) / 32 * 4;  // whole 32-bit words
  const std::size_t n_bytes = row_bytes * static_cast<std::size_t>(file.height);
  if (!file.in.u8(file.pixels_at + n_bytes - 1)) return false;
  for (int i = 0; i < file.height; ++i) {
    const std::size_t row_at = file.pixels_at + static_cast<std::size_t>(i) * row_bytes;
    std::size_t x = 0;
    for (float& level : file.row(image, i)) level = bmp_level(file, row_at, x++);
  }
  return true;
}

/// Runs of 4 or 8 bit. What they leave out has the first colour of the palette.
bool read_bmp_runs(const BmpFile& file, Image& image) {
  std::fill(image.pixels().begin(), image.pixels().end(), file.palette[0]);
  const auto width = static_cast<std::size_t>(file.width);
  std::size_t at = file.pixels_at;
  std::size_t x = 0;
  std::size_t y = 0;
  const auto color = [&](std::uint32_t byte, std::size_t i) {
    if (file.bits == 8) return file.palette[byte];
    return file.palette[i % 2 == 0 ? byte >> 4 : byte & 15];
  };
  while (true) {
    const auto first = file.in.u8(at);
    const auto second = file.in.u8(at + 1);
    if (!second) return y + 1 >= static_cast<std::size_t>(file.height) && x >= width;
    at += 2;
    if (*first == 0 && *second == 1) return true;  // the end
    if (*first == 0 && *second == 0) {             // the next row
      x = 0;
      ++y;
      continue;
    }
    if (*first == 0 && *second == 2) {  // go on elsewhere
      const auto right = file.in.u8(at);
      const auto up = file.in.u8(at + 1);
      if (!up) return false;
      at += 2;
      x += *right;
      y += *up;
      continue;
    }
    const bool is_run = *first != 0;
    const std::size_t n = is_run ? *first : *second;
    if (y >= static_cast<std::size_t>(file.height) || x + n > width) return false;
    const std::size_t n_bytes = is_run ? 0 : (n * file.bits + 7) / 8;
    if (n_bytes > 0 && !file.in.u8(at + n_bytes - 1)) return false;
    const auto row = file.row(image, static_cast<int>(y));
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t byte = is_run ? *second : *file.in.u8(at + i * file.bits / 8);
      row[x + i] = color(byte, i);
    }
    x += n;
    at += (n_bytes + 1) / 2 * 2;  // whole words
  }
}

}  // namespace

Decoded decode_bmp(std::string_view bytes, const PictureHeader& header) {
  const std::optional<BmpFile> file = bmp_file(bytes, header);
  if (!file) return tl::unexpected<std::string>("a header that no BMP of this size has");
  Image image(file->width, file->height, Image::kFullScale8);
  const bool has_runs = file->compression == kBmpRuns8 || file->compression == kBmpRuns4;
  if (has_runs ? !read_bmp_runs(*file, image) : !read_bmp_rows(*file, image)) {
    return tl::unexpected<std::string>("its pixels are cut off");
  }
  return image;
}

}  // namespace panelcal::internal
