// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/formats/tiff_directory.h"

#include <array>

#include "vision/picture/formats/byte_reader.h"

namespace panelcal::internal {
namespace {

using namespace std::string_view_literals;

// Tags, types and values as TIFF 6.0 numbers them.
enum Tag : std::uint32_t {
  kImageWidth = 256,
  kImageLength = 257,
  kBitsPerSample = 258,
  kPhotometricInterpretation = 262,
  kOrientation = 274,
  kSamplesPerPixel = 277,
  kTileWidth = 322,
  kTileLength = 323,
  kExtraSamples = 338,
  kSampleFormat = 339,
};
constexpr std::array<std::uint32_t, 10> kTags = {kImageWidth,
                                                 kImageLength,
                                                 kBitsPerSample,
                                                 kPhotometricInterpretation,
                                                 kOrientation,
                                                 kSamplesPerPixel,
                                                 kTileWidth,
                                                 kTileLength,
                                                 kExtraSamples,
                                                 kSampleFormat};
constexpr std::uint32_t kShort = 3;
constexpr std::uint32_t kLong = 4;
constexpr std::uint32_t kTopLeft = 1;
constexpr std::uint32_t kAssociatedAlpha = 1;
constexpr std::uint32_t kUnassociatedAlpha = 2;

/// The first of an entry's values, and where it stands.
struct FirstValue {
  std::uint32_t value = 0;
  std::size_t at = 0;
  bool is_short = false;
};

/// Only SHORT and LONG: what panelcal asks for is written in no other type.
std::optional<FirstValue> first_value(const ByteReader& in, std::size_t entry) {
  const auto type = in.u16(entry + 2);
  const auto count = in.u32(entry + 4);
  if (!type || !count || *count == 0 || (*type != kShort && *type != kLong)) return std::nullopt;
  const bool is_short = *type == kShort;
  FirstValue first{0, entry + 8, is_short};
  if (*count > (is_short ? 2U : 1U)) {
    const auto offset = in.u32(entry + 8);
    if (!offset) return std::nullopt;
    first.at = *offset;
  }
  const auto value = is_short ? in.u16(first.at) : in.u32(first.at);
  if (!value) return std::nullopt;
  first.value = *value;
  return first;
}

void take(std::uint32_t tag, const FirstValue& first, TiffDirectory& directory) {
  switch (tag) {
    case kImageWidth:
      directory.width = first.value;
      break;
    case kImageLength:
      directory.height = first.value;
      break;
    case kTileWidth:
      directory.tile_width = first.value;
      break;
    case kTileLength:
      directory.tile_height = first.value;
      break;
    case kBitsPerSample:
      directory.bits = first.value;
      break;
    case kSamplesPerPixel:
      directory.samples = first.value;
      break;
    case kPhotometricInterpretation:
      directory.photometric = first.value;
      break;
    case kSampleFormat:
      directory.sample_format = first.value;
      break;
    case kOrientation:
      directory.orientation_at = first.at;
      break;
    case kExtraSamples:
      directory.first_extra_sample_at = first.at;
      break;
    default:
      break;
  }
}

void put_u16(std::string& bytes, std::size_t at, std::uint32_t value, bool big_endian) {
  bytes[at] = static_cast<char>(big_endian ? value >> 8 : value);
  bytes[at + 1] = static_cast<char>(big_endian ? value : value >> 8);
}

}  // namespace

std::optional<TiffDirectory> tiff_directory(std::string_view bytes) {
  TiffDirectory directory;
  directory.big_endian = bytes.starts_with("MM"sv);
  const ByteReader in(bytes, directory.big_endian);
  const auto start = in.u32(4);
  const auto n_entries = start ? in.u16(*start) : std::nullopt;
  if (!n_entries) return std::nullopt;
  std::array<bool, kTags.size()> is_seen{};
  for (std::size_t i = 0; i < *n_entries; ++i) {
    const std::size_t entry = std::size_t{*start} + 2 + 12 * i;
    const auto tag = in.u16(entry);
    if (!tag || !in.u32(entry + 8)) return std::nullopt;
    for (std::size_t k = 0; k < kTags.size(); ++k) {
      if (kTags[k] != *tag) continue;
      const auto first = first_value(in, entry);
      // Orientation and extra samples are patched as 16-bit numbers, which they have to be.
      const bool is_patched = *tag == kOrientation || *tag == kExtraSamples;
      if (!first || is_seen[k] || (is_patched && !first->is_short)) return std::nullopt;
      is_seen[k] = true;
      take(*tag, *first, directory);
    }
  }
  return directory;
}

std::optional<std::string> without_orientation_and_alpha(std::string_view bytes,
                                                         const TiffDirectory& directory) {
  const ByteReader in(bytes, directory.big_endian);
  const bool is_turned = directory.orientation_at && in.u16(*directory.orientation_at) != kTopLeft;
  const bool has_alpha = directory.first_extra_sample_at &&
                         in.u16(*directory.first_extra_sample_at) == kUnassociatedAlpha;
  if (!is_turned && !has_alpha) return std::nullopt;
  std::string patched(bytes);
  if (is_turned) put_u16(patched, *directory.orientation_at, kTopLeft, directory.big_endian);
  // Levels that are already multiplied are left as they are.
  if (has_alpha) {
    put_u16(patched, *directory.first_extra_sample_at, kAssociatedAlpha, directory.big_endian);
  }
  return patched;
}

}  // namespace panelcal::internal
