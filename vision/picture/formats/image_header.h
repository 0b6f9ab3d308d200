// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

namespace panelcal::internal {

enum class PictureKind { Png, Tiff, Bmp, Jpeg };

std::string_view name(PictureKind kind);

/// The header of a picture file, read without decoding it.
struct PictureHeader {
  PictureKind kind = PictureKind::Png;
  std::int64_t width = 0;
  std::int64_t height = 0;
};

/// The kind by the first bytes; empty if it is not one of the four.
std::optional<PictureKind> picture_kind(std::string_view bytes);

/// The size as the header claims it; empty if the header is cut off or damaged.
std::optional<PictureHeader> picture_header(std::string_view bytes, PictureKind kind);

/// True if the file has the end its format asks for. PNG and JPEG have end marks; the decoders of
/// the others notice themselves.
bool has_end_mark(std::string_view bytes, PictureKind kind);

}  // namespace panelcal::internal
