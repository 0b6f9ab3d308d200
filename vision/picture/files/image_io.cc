// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/files/image_io.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "vision/picture/formats/decoder.h"
#include "vision/picture/formats/image_header.h"
#include "vision/picture/formats/jpeg_encoder.h"
#include "vision/picture/formats/png_codec.h"
#include "vision/picture/formats/tiff_directory.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::PictureHeader;
using internal::PictureKind;
using internal::TiffDirectory;

constexpr std::size_t kMaxFileBytes = std::size_t{1} << 30;
constexpr std::string_view kKinds = "PNG, TIFF, BMP or JPEG of 8 or 16 bit";
/// Deflate makes at most 1032 bytes of one, which hold 8 pixels each.
constexpr std::int64_t kMaxPixelsPerByte = 1032 * 8;

tl::unexpected<Diagnostic> file_problem(Code code,
                                        std::string_view name,
                                        std::string what,
                                        std::string expected) {
  return failure({code, {std::string(name), 0, 0}, std::move(what), std::move(expected)});
}

tl::unexpected<Diagnostic> cannot_encode(std::string_view why) {
  return file_problem(
      Code::PictureFormat, "", "cannot encode a picture: " + quoted(why), "a picture");
}

/// Message of a decoder, in one printable line.
std::string first_line(std::string_view words) {
  return quoted(words.substr(0, words.find('\n')), 160);
}

/// Levels rounded to even and clipped.
template <class Sample>
void put_samples(const Image& image, std::vector<unsigned char>& bytes) {
  unsigned char* to = bytes.data();
  for (const float level : image.pixels()) {
    const float clipped =
        level > 0 ? std::min(level, float{std::numeric_limits<Sample>::max()}) : 0.0F;
    const auto sample = static_cast<Sample>(std::nearbyint(clipped));
    std::memcpy(to, &sample, sizeof sample);
    to += sizeof sample;
  }
}

/// Does what the decoder leaves undone on TIFF pixels of more than 8 bit: it does not turn around
/// pictures whose 0 is white, and it shifts 10, 12 and 14 bits up, so that white is below 65535.
void finish_levels(const TiffDirectory& directory, Image& image) {
  const bool is_negative = directory.photometric == TiffDirectory::kMinIsWhite;
  if (directory.bits <= 8 || (directory.bits == 16 && !is_negative)) return;
  const std::uint32_t white = ((1U << directory.bits) - 1) << (16 - directory.bits);
  // In double, so that white is exactly full scale and saturation is recognised.
  const double factor = Image::kFullScale16 / white;
  for (float& level : image.pixels()) {
    const double positive = factor * level;
    level = static_cast<float>(is_negative ? Image::kFullScale16 - positive : positive);
  }
}

Expected<PictureHeader> checked_header(std::string_view bytes,
                                       std::string_view name,
                                       PictureKind kind) {
  const auto header = internal::picture_header(bytes, kind);
  if (!header) {
    return file_problem(Code::PictureDamaged,
                        name,
                        fmt::format("the {} header is cut off or damaged", internal::name(kind)),
                        "a whole picture");
  }
  // Divided, since the product of two claims may overflow.
  if (header->width > kMaxPicturePixels / header->height) {
    return file_problem(Code::PictureTooLarge,
                        name,
                        fmt::format("{} x {} pixels", header->width, header->height),
                        fmt::format("at most {} pixels", kMaxPicturePixels));
  }
  const auto n_bytes = static_cast<std::int64_t>(bytes.size());
  if (header->width * header->height / kMaxPixelsPerByte > n_bytes) {
    return file_problem(
        Code::PictureDamaged,
        name,
        fmt::format("{} bytes for {} x {} pixels", n_bytes, header->width, header->height),
        fmt::format("at most {} pixels a byte", kMaxPixelsPerByte));
  }
  if (!internal::has_end_mark(bytes, kind)) {
    return file_problem(Code::PictureDamaged,
                        name,
                        fmt::format("the {} file is cut off", internal::name(kind)),
                        "a whole picture");
  }
  return *header;
}

/// Refuses what the decoder would read wrongly or with too much memory.
Expected<void> check_tiff(const TiffDirectory& directory, std::string_view name) {
  if (directory.sample_format != 1) {
    return file_problem(
        Code::PictureFormat, name, "pixels are floating-point or signed numbers", "8 or 16 bit");
  }
  constexpr std::array<std::uint32_t, 6> kBits = {1, 8, 10, 12, 14, 16};
  if (std::find(kBits.begin(), kBits.end(), directory.bits) == kBits.end()) {
    return file_problem(
        Code::PictureFormat, name, fmt::format("{} bits a pixel", directory.bits), "8 or 16 bit");
  }
  // Up to 8 bit the decoder translates every kind of colour, above that it passes numbers on.
  const bool is_plain = directory.photometric <= TiffDirectory::kRgb;
  if (directory.samples < 1 || directory.samples > 4 || (directory.bits > 8 && !is_plain)) {
    return file_problem(Code::PictureFormat,
                        name,
                        fmt::format("{} samples a pixel, photometric interpretation {}",
                                    directory.samples,
                                    directory.photometric),
                        "grey, RGB or RGBA");
  }
  // Tiles may reach beyond the picture, and small pictures often have one large tile.
  constexpr std::int64_t kSpare = 4096;
  if (directory.tile_width > directory.width + kSpare ||
      directory.tile_height > directory.height + kSpare) {
    return file_problem(Code::PictureDamaged,
                        name,
                        fmt::format("tiles of {} x {} in a picture of {} x {}",
                                    directory.tile_width,
                                    directory.tile_height,
                                    directory.width,
                                    directory.height),
                        "tiles about as large as the picture at most");
  }
  return {};
}

Expected<Image> undamaged(internal::Decoded decoded, PictureKind kind, std::string_view name) {
  if (decoded) return *std::move(decoded);
  const std::string& words = decoded.error();
  return file_problem(Code::PictureDamaged,
                      name,
                      fmt::format("the {} does not decode{}",
                                  internal::name(kind),
                                  words.empty() ? words : ": " + first_line(words)),
                      "a whole picture");
}

Expected<Image> decode_tiff(std::string_view bytes,
                            std::string_view name,
                            const PictureHeader& header) {
  // There is one, else there were no header.
  const TiffDirectory directory = internal::tiff_directory(bytes).value_or(TiffDirectory());
  PANELCAL_CHECK(check_tiff(directory, name));
  const auto patched = internal::without_orientation_and_alpha(bytes, directory);
  PANELCAL_TRY(
      Image image,
      undamaged(
          internal::decode_tiff(patched ? *patched : bytes, header, directory), header.kind, name));
  finish_levels(directory, image);
  return image;
}

}  // namespace

Expected<Image> decode_image(std::string_view bytes, std::string_view name) {
  const std::optional<PictureKind> kind = internal::picture_kind(bytes);
  if (!kind) {
    return file_problem(Code::PictureFormat,
                        name,
                        bytes.empty() ? "the file is empty" : "not a picture of a known kind",
                        std::string(kKinds));
  }
  PANELCAL_TRY(const PictureHeader header, checked_header(bytes, name, *kind));
  if (*kind == PictureKind::Tiff) return decode_tiff(bytes, name, header);
  const auto decode = *kind == PictureKind::Png    ? internal::decode_png
                      : *kind == PictureKind::Jpeg ? internal::decode_jpeg
                                                   : internal::decode_bmp;
  return undamaged(decode(bytes, header), *kind, name);
}

Expected<Image> read_image(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string bytes, read_file(path, kMaxFileBytes));
  return decode_image(bytes, path.string());
}

Expected<std::string> encode_png(const Image& image) {
  if (image.empty()) return cannot_encode("no pixels");
  const bool is_deep = image.full_scale() > Image::kFullScale8;
  const std::size_t sample_bytes = is_deep ? 2 : 1;
  std::vector<unsigned char> samples(image.pixels().size() * sample_bytes);
  if (is_deep) {
    put_samples<std::uint16_t>(image, samples);
  } else {
    put_samples<std::uint8_t>(image, samples);
  }
  auto png = internal::encode_png_pixels({.first_row = samples.data(),
                                          .row_bytes = static_cast<std::ptrdiff_t>(image.width()) *
                                                       static_cast<std::ptrdiff_t>(sample_bytes),
                                          .width = image.width(),
                                          .height = image.height(),
                                          .bits = is_deep ? 16 : 8});
  if (!png) return cannot_encode(png.error());
  return *std::move(png);
}

Expected<std::string> encode_jpeg(const Image& image, int max_side_px) {
  if (image.empty()) return cannot_encode("no pixels");
  constexpr int kQuality = 82;  // half the bytes of 95, and edges stay
  const int side_px = std::max(image.width(), image.height());
  const int factor = std::min(
      {(side_px + max_side_px - 1) / std::max(1, max_side_px), image.width(), image.height()});
  const int width = image.width() / factor;
  const int height = image.height() / factor;
  const double scale = Image::kFullScale8 / image.full_scale() / (factor * factor);
  std::vector<unsigned char> levels;
  levels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int i = 0; i < factor * factor; ++i) {
        sum += static_cast<double>(image.at(x * factor + i % factor, y * factor + i / factor));
      }
      const double level = std::clamp(std::round(sum * scale), 0.0, Image::kFullScale8);
      levels.push_back(static_cast<unsigned char>(level));
    }
  }
  std::string jpeg = internal::encode_grey_jpeg(levels, width, height, kQuality);
  if (jpeg.empty()) return cannot_encode("no memory");
  return jpeg;
}

Expected<void> write_png(const std::filesystem::path& path, const Image& image) {
  PANELCAL_TRY(const std::string bytes, encode_png(image));
  return write_file(path, bytes);
}

}  // namespace panelcal
