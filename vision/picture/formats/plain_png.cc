// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/formats/plain_png.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "vision/picture/formats/byte_reader.h"
#include "vision/picture/formats/sample_row.h"
#include <libdeflate.h>

namespace panelcal::internal {
namespace {

constexpr std::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);
/// Chunks about colour and origin, whose contents change no pixel.
constexpr std::array<std::string_view, 7> kHarmlessChunks = {
    "cHRM", "gAMA", "pHYs", "sBIT", "sRGB", "tEXt", "tIME"};
/// Below the limits from which on libpng refuses.
constexpr std::uint32_t kMaxHarmlessBytes = 1U << 16;
constexpr std::uint32_t kMaxDataBytes = 8'000'000;
constexpr std::uint32_t kMaxSide_px = 1'000'000;
constexpr std::uint32_t kWindowOf16 = 7;  ///< a zlib stream's header: history of 2^(8 + 7) bytes

struct PlainHeader {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t n_channels = 1;
  std::uint32_t sample_bytes = 1;

  std::size_t pixel_bytes() const { return std::size_t{n_channels} * sample_bytes; }
  std::size_t row_bytes() const { return width * pixel_bytes(); }
  /// With the number of its filter before every row.
  std::size_t all_bytes() const { return height * (row_bytes() + 1); }
};

std::optional<PlainHeader> plain_header(std::string_view data) {
  if (data.size() != 13) return std::nullopt;
  const ByteReader reader(data, true);
  PlainHeader header{*reader.u32(0), *reader.u32(4)};
  if (header.width == 0 || header.height == 0) return std::nullopt;
  if (header.width > kMaxSide_px || header.height > kMaxSide_px) return std::nullopt;
  const std::uint32_t bits = *reader.u8(8);
  if (bits != 8 && bits != 16) return std::nullopt;
  header.sample_bytes = bits / 8;
  constexpr std::array<std::uint32_t, 7> kChannels = {1, 0, 3, 0, 2, 0, 4};  // by colour type
  const std::uint32_t color = *reader.u8(9);
  if (color >= kChannels.size() || kChannels[color] == 0) return std::nullopt;
  header.n_channels = kChannels[color];
  const bool is_plain = *reader.u8(10) == 0 && *reader.u8(11) == 0 && *reader.u8(12) == 0;
  return is_plain ? std::optional(header) : std::nullopt;
}

struct PlainChunk {
  std::string_view kind;
  std::string_view data;
};

/// Takes a chunk off the front; empty if it is not whole or its checksum is wrong.
std::optional<PlainChunk> next_chunk(std::string_view& rest) {
  const ByteReader reader(rest, true);
  const auto n = reader.u32(0);
  if (!n || *n > kMaxDataBytes || rest.size() < std::size_t{12} + *n) return std::nullopt;
  const PlainChunk chunk{rest.substr(4, 4), rest.substr(8, *n)};
  if (libdeflate_crc32(0, chunk.kind.data(), 4 + *n) != *reader.u32(8 + *n)) return std::nullopt;
  rest.remove_prefix(std::size_t{12} + *n);
  return chunk;
}

struct PlainPng {
  PlainHeader header;
  std::string_view data;  ///< of all IDAT chunks
  std::string joined;     ///< behind `data`, if there are several
};

/// Follows the chunks to IEND. Anything out of the ordinary ends it.
bool read_chunks(std::string_view rest, PlainPng& png) {
  const auto first = next_chunk(rest);
  if (!first || first->kind != "IHDR") return false;
  const auto header = plain_header(first->data);
  if (!header) return false;
  png.header = *header;
  std::size_t n_data = 0;
  bool is_past_data = false;
  while (const auto chunk = next_chunk(rest)) {
    if (chunk->kind == "IEND") {
      if (n_data > 1) png.data = png.joined;
      return n_data > 0 && chunk->data.empty();
    }
    if (chunk->kind == "IDAT") {
      if (is_past_data || chunk->data.empty()) return false;
      if (n_data++ == 0) {
        png.data = chunk->data;
        continue;
      }
      if (n_data == 2) png.joined = png.data;
      png.joined += chunk->data;
      continue;
    }
    is_past_data = n_data > 0;
    const bool is_harmless =
        std::ranges::find(kHarmlessChunks, chunk->kind) != kHarmlessChunks.end();
    if (!is_harmless || chunk->data.size() > kMaxHarmlessBytes) return false;
  }
  return false;
}

/// True if zlib would keep enough history: libdeflate keeps all of it, and would read more.
bool has_enough_window(const PlainPng& png) {
  const auto first = ByteReader(png.data, true).u8(0);
  if (!first) return false;
  const std::uint32_t window = *first >> 4;
  return window == kWindowOf16 ||
         (window < kWindowOf16 && png.header.all_bytes() <= std::size_t{256} << window);
}

bool inflate(std::string_view data, std::vector<std::uint8_t>& out) {
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>
      decompressor(libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
  if (!decompressor) return false;
  std::size_t n_in = 0;
  std::size_t n_out = 0;
  const libdeflate_result result = libdeflate_zlib_decompress_ex(
      decompressor.get(), data.data(), data.size(), out.data(), out.size(), &n_in, &n_out);
  return result == LIBDEFLATE_SUCCESS && n_in == data.size() && n_out == out.size();
}

std::uint8_t sum(unsigned a, unsigned b) {
  return static_cast<std::uint8_t>(a + b);
}

unsigned paeth(unsigned left, unsigned above, unsigned corner) {
  const int from_left = std::abs(static_cast<int>(above) - static_cast<int>(corner));
  const int from_above = std::abs(static_cast<int>(left) - static_cast<int>(corner));
  const int from_corner =
      std::abs(static_cast<int>(left) + static_cast<int>(above) - 2 * static_cast<int>(corner));
  if (from_left <= from_above && from_left <= from_corner) return left;
  return from_above <= from_corner ? above : corner;
}

/// Undoes a row's filter in place; `kReach` is a pixel's number of bytes, known to the compiler
/// since its loops are most of the work. False for a filter that there is not.
template <std::size_t kReach>
bool unfilter(unsigned filter, std::uint8_t* row, const std::uint8_t* above, std::size_t n) {
  switch (filter) {
    case 0:
      return true;
    case 1:
      for (std::size_t i = kReach; i < n; ++i) row[i] = sum(row[i], row[i - kReach]);
      return true;
    case 2:
      for (std::size_t i = 0; i < n; ++i) row[i] = sum(row[i], above[i]);
      return true;
    case 3:
      for (std::size_t i = 0; i < kReach; ++i) row[i] = sum(row[i], above[i] / 2U);
      for (std::size_t i = kReach; i < n; ++i) {
        row[i] = sum(row[i], (unsigned{row[i - kReach]} + above[i]) / 2);
      }
      return true;
    case 4:
      for (std::size_t i = 0; i < kReach; ++i) row[i] = sum(row[i], above[i]);
      for (std::size_t i = kReach; i < n; ++i) {
        row[i] = sum(row[i], paeth(row[i - kReach], above[i], above[i - kReach]));
      }
      return true;
    default:
      return false;
  }
}

using Unfilter = bool (*)(unsigned, std::uint8_t*, const std::uint8_t*, std::size_t);

Unfilter unfilter_of(std::size_t pixel_bytes) {
  switch (pixel_bytes) {
    case 1:
      return unfilter<1>;
    case 2:
      return unfilter<2>;
    case 3:
      return unfilter<3>;
    case 4:
      return unfilter<4>;
    case 6:
      return unfilter<6>;
    default:
      return unfilter<8>;
  }
}

/// Samples of 16 bit stand with their high byte first.
void copy_plain_row(const PlainHeader& header,
                    const std::uint8_t* row,
                    std::vector<std::uint16_t>& samples,
                    std::span<float> levels) {
  const auto n_channels = static_cast<int>(header.n_channels);
  if (header.sample_bytes == 1) return copy_row(row, n_channels, levels);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] = static_cast<std::uint16_t>(row[2 * i] << 8 | row[2 * i + 1]);
  }
  copy_row(samples.data(), n_channels, levels);
}

}  // namespace

std::optional<Image> read_plain_png(std::string_view bytes) {
  if (!bytes.starts_with(kPngSignature)) return std::nullopt;
  PlainPng png;
  if (!read_chunks(bytes.substr(kPngSignature.size()), png)) return std::nullopt;
  if (!has_enough_window(png)) return std::nullopt;
  const PlainHeader& header = png.header;
  std::vector<std::uint8_t> rows(header.all_bytes());
  if (!inflate(png.data, rows)) return std::nullopt;

  Image image(static_cast<int>(header.width),
              static_cast<int>(header.height),
              header.sample_bytes == 2 ? Image::kFullScale16 : Image::kFullScale8);
  const Unfilter undo = unfilter_of(header.pixel_bytes());
  const std::size_t n = header.row_bytes();
  const std::vector<std::uint8_t> zeros(n);
  std::vector<std::uint16_t> samples(header.sample_bytes == 2 ? n / 2 : 0);
  const std::uint8_t* above = zeros.data();
  for (int y = 0; y < image.height(); ++y) {
    std::uint8_t* row = rows.data() + static_cast<std::size_t>(y) * (n + 1);
    if (!undo(row[0], row + 1, above, n)) return std::nullopt;
    copy_plain_row(header, row + 1, samples, image.row(y));
    above = row + 1;
  }
  return image;
}

}  // namespace panelcal::internal
