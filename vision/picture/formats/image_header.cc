// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/formats/image_header.h"

#include <cstddef>
#include <cstdlib>

#include "vision/picture/formats/byte_reader.h"
#include "vision/picture/formats/tiff_directory.h"

namespace panelcal::internal {
namespace {

using namespace std::string_view_literals;

using Size = std::optional<std::pair<std::int64_t, std::int64_t>>;

/// PNG specification 11.2.2: IHDR comes first.
Size png_size(std::string_view bytes) {
  const ByteReader in(bytes, true);
  if (bytes.substr(12, 4) != "IHDR"sv) return std::nullopt;
  const auto width = in.u32(16);
  const auto height = in.u32(20);
  if (!width || !height) return std::nullopt;
  return std::pair<std::int64_t, std::int64_t>(*width, *height);
}

/// BITMAPCOREHEADER has 16-bit sizes, all later headers 32-bit ones; a negative height means that
/// the top row comes first.
Size bmp_size(std::string_view bytes) {
  const ByteReader in(bytes, false);
  const auto header_size = in.u32(14);
  if (!header_size) return std::nullopt;
  if (*header_size == 12) {
    const auto width = in.u16(18);
    const auto height = in.u16(20);
    if (!width || !height) return std::nullopt;
    return std::pair<std::int64_t, std::int64_t>(*width, *height);
  }
  const auto width = in.u32(18);
  const auto height = in.u32(22);
  if (!width || !height) return std::nullopt;
  return std::pair<std::int64_t, std::int64_t>(static_cast<std::int32_t>(*width),
                                               std::llabs(static_cast<std::int32_t>(*height)));
}

bool is_start_of_frame(std::uint32_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

/// JPEG (ITU-T T.81, B.1.1): walk the segments to the first frame header.
Size jpeg_size(std::string_view bytes) {
  const ByteReader in(bytes, true);
  std::size_t at = 2;
  while (true) {
    const auto prefix = in.u8(at);
    const auto marker = in.u8(at + 1);
    if (!marker || *prefix != 0xFF) return std::nullopt;
    if (*marker == 0xFF) {  // fill byte
      ++at;
      continue;
    }
    const auto length = in.u16(at + 2);
    if (!length || *length < 2) return std::nullopt;
    if (is_start_of_frame(*marker)) {
      const auto height = in.u16(at + 5);
      const auto width = in.u16(at + 7);
      if (!width || !height) return std::nullopt;
      return std::pair<std::int64_t, std::int64_t>(*width, *height);
    }
    at += 2 + *length;
  }
}

Size tiff_size(std::string_view bytes) {
  const auto directory = tiff_directory(bytes);
  if (!directory) return std::nullopt;
  return std::pair(directory->width, directory->height);
}

Size size_of(std::string_view bytes, PictureKind kind) {
  switch (kind) {
    case PictureKind::Png:
      return png_size(bytes);
    case PictureKind::Tiff:
      return tiff_size(bytes);
    case PictureKind::Bmp:
      return bmp_size(bytes);
    case PictureKind::Jpeg:
      return jpeg_size(bytes);
  }
  return std::nullopt;
}

}  // namespace

std::string_view name(PictureKind kind) {
  switch (kind) {
    case PictureKind::Png:
      return "PNG";
    case PictureKind::Tiff:
      return "TIFF";
    case PictureKind::Bmp:
      return "BMP";
    case PictureKind::Jpeg:
      return "JPEG";
  }
  return {};
}

std::optional<PictureKind> picture_kind(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1A\n"sv)) return PictureKind::Png;
  if (bytes.starts_with("II*\0"sv) || bytes.starts_with("MM\0*"sv)) return PictureKind::Tiff;
  if (bytes.starts_with("BM"sv)) return PictureKind::Bmp;
  if (bytes.starts_with("\xFF\xD8\xFF"sv)) return PictureKind::Jpeg;
  return std::nullopt;
}

std::optional<PictureHeader> picture_header(std::string_view bytes, PictureKind kind) {
  if (bytes.size() < 16) return std::nullopt;
  const Size size = size_of(bytes, kind);
  if (!size || size->first <= 0 || size->second <= 0) return std::nullopt;
  return PictureHeader{kind, size->first, size->second};
}

bool has_end_mark(std::string_view bytes, PictureKind kind) {
  // Some cameras append their own data, so the mark need not be the very last thing.
  if (kind == PictureKind::Png) return bytes.find("IEND"sv) != std::string_view::npos;
  if (kind == PictureKind::Jpeg) return bytes.rfind("\xFF\xD9"sv) != std::string_view::npos;
  return true;
}

}  // namespace panelcal::internal
