// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <span>
#include <vector>

#include "vision/picture/formats/decoder.h"
#include "vision/picture/formats/sample_row.h"
#include <tiffio.h>

namespace panelcal::internal {
namespace {

/// More words would be of no use.
constexpr std::size_t kMaxWords = 4096;
/// No buffer of a picture in reach is larger, whatever the file claims.
constexpr tmsize_t kMaxAllocation = tmsize_t{1} << 30;

/// A file in memory, and what libtiff says of it.
struct TiffInput {
  std::string_view bytes;
  std::size_t at = 0;
  std::string words;
};

TiffInput& tiff_input(thandle_t handle) {
  return *static_cast<TiffInput*>(handle);
}

tmsize_t read_tiff_bytes(thandle_t handle, void* to, tmsize_t n) {
  TiffInput& input = tiff_input(handle);
  const std::size_t left = input.bytes.size() - std::min(input.at, input.bytes.size());
  const std::size_t n_read = std::min(static_cast<std::size_t>(std::max<tmsize_t>(n, 0)), left);
  if (n_read > 0) std::memcpy(to, input.bytes.data() + input.at, n_read);
  input.at += n_read;
  return static_cast<tmsize_t>(n_read);
}

tmsize_t refuse_tiff_write(thandle_t /*handle*/, void* /*from*/, tmsize_t /*n*/) {
  return 0;
}

toff_t seek_tiff(thandle_t handle, toff_t offset, int whence) {
  TiffInput& input = tiff_input(handle);
  toff_t at = offset;
  if (whence == SEEK_CUR) at += input.at;
  if (whence == SEEK_END) at += input.bytes.size();
  input.at = static_cast<std::size_t>(std::min<toff_t>(at, input.bytes.size()));
  return input.at;
}

int close_tiff(thandle_t /*handle*/) {
  return 0;
}

toff_t tiff_file_size(thandle_t handle) {
  return tiff_input(handle).bytes.size();
}

int map_tiff(thandle_t /*handle*/, void** /*base*/, toff_t* /*size*/) {
  return 0;
}

void unmap_tiff(thandle_t /*handle*/, void* /*base*/, toff_t /*size*/) {
}

int note_tiff_words(
    TIFF* /*tiff*/, void* user, const char* module, const char* format, va_list arguments) {
  std::string& all = static_cast<TiffInput*>(user)->words;
  std::array<char, 512> line{};
  std::vsnprintf(line.data(), line.size(), format, arguments);
  try {
    if (all.size() < kMaxWords) {
      if (module != nullptr && *module != '\0') all.append(module).append(": ");
      all.append(line.data()).append("\n");
    }
  } catch (const std::exception&) {  // must not fly through C
  }
  return 1;
}

struct TiffCloser {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
  void operator()(TIFFOpenOptions* options) const { TIFFOpenOptionsFree(options); }
};
using TiffHandle = std::unique_ptr<TIFF, TiffCloser>;

TiffHandle open_tiff(TiffInput& input) {
  const std::unique_ptr<TIFFOpenOptions, TiffCloser> options(TIFFOpenOptionsAlloc());
  if (!options) return nullptr;
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMaxAllocation);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), note_tiff_words, &input);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), note_tiff_words, &input);
  return TiffHandle(TIFFClientOpenExt("",
                                      "r",
                                      &input,
                                      read_tiff_bytes,
                                      refuse_tiff_write,
                                      seek_tiff,
                                      close_tiff,
                                      tiff_file_size,
                                      map_tiff,
                                      unmap_tiff,
                                      options.get()));
}

/// True if libtiff says no more than that a directory has entries it does not know.
bool is_harmless(std::string_view words) {
  constexpr std::array<std::string_view, 3> kHarmless = {
      "Unknown field with tag", "does not end in null byte", "tags are not sorted"};
  // Words beyond what is kept might be of damage.
  if (words.size() >= kMaxWords) return false;
  while (!words.empty()) {
    const std::size_t end = std::min(words.find('\n'), words.size());
    const std::string_view line = words.substr(0, end);
    const bool is_known = std::ranges::any_of(kHarmless, [&](std::string_view known) {
      return line.find(known) != std::string_view::npos;
    });
    if (!line.empty() && !is_known) return false;
    words.remove_prefix(std::min(end + 1, words.size()));
  }
  return true;
}

/// Strips as wide as the picture, or tiles.
struct TiffPieces {
  bool is_tiled = false;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

/// Empty if the file claims pieces that are not checked, or none.
TiffPieces pieces_of(TIFF* tiff, const PictureHeader& header, const TiffDirectory& directory) {
  TiffPieces pieces;
  pieces.is_tiled = TIFFIsTiled(tiff) != 0;
  if (pieces.is_tiled) {
    TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &pieces.width);
    TIFFGetField(tiff, TIFFTAG_TILELENGTH, &pieces.height);
    const bool is_checked =
        pieces.width == directory.tile_width && pieces.height == directory.tile_height;
    return is_checked ? pieces : TiffPieces();
  }
  pieces.width = static_cast<std::uint32_t>(header.width);
  TIFFGetField(tiff, TIFFTAG_ROWSPERSTRIP, &pieces.height);
  const auto n_rows = static_cast<std::uint32_t>(header.height);
  if (pieces.height == 0 || pieces.height > n_rows) pieces.height = n_rows;
  return pieces;
}

/// Calls read(x, y, n_columns, n_rows) for each piece, until one fails.
template <class Read>
bool for_each_piece(const TiffPieces& pieces, const Image& image, const Read& read) {
  const int width = static_cast<int>(pieces.width);
  const int height = static_cast<int>(pieces.height);
  for (int y = 0; y < image.height(); y += height) {
    for (int x = 0; x < image.width(); x += width) {
      if (!read(x, y, std::min(width, image.width() - x), std::min(height, image.height() - y))) {
        return false;
      }
    }
  }
  return true;
}

std::span<float> row_part(Image& image, int y, int x, int n_columns) {
  return image.row(y).subspan(static_cast<std::size_t>(x), static_cast<std::size_t>(n_columns));
}

/// Up to 8 bit libtiff translates every kind of colour to RGBA, from the bottom row up.
bool read_rgba(TIFF* tiff, const TiffPieces& pieces, bool is_rounded, Image& image) {
  std::vector<std::uint32_t> raster(static_cast<std::size_t>(pieces.width) * pieces.height);
  return for_each_piece(pieces, image, [&](int x, int y, int n_columns, int n_rows) {
    const int is_read =
        pieces.is_tiled
            ? TIFFReadRGBATile(
                  tiff, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), raster.data())
            : TIFFReadRGBAStrip(tiff, static_cast<std::uint32_t>(y), raster.data());
    if (is_read == 0) return false;
    // A tile is always whole: its first row is the last one of the raster.
    const std::uint32_t bottom =
        pieces.is_tiled ? pieces.height - static_cast<std::uint32_t>(n_rows) : 0;
    for (int i = 0; i < n_rows; ++i) {
      const std::uint32_t* pixel =
          raster.data() +
          static_cast<std::size_t>(bottom + static_cast<std::uint32_t>(i)) * pieces.width;
      for (float& level : row_part(image, y + n_rows - 1 - i, x, n_columns)) {
        const std::uint32_t red = TIFFGetR(*pixel);
        const std::uint32_t green = TIFFGetG(*pixel);
        const std::uint32_t blue = TIFFGetB(*pixel);
        level = is_rounded ? rounded_luma(red, green, blue)
                           : luma(static_cast<float>(blue),
                                  static_cast<float>(green),
                                  static_cast<float>(red));
        ++pixel;
      }
    }
    return true;
  });
}

/// Numbers of a few bits, the first at the high end, shifted up to 16 bit.
void unpack_bits(std::span<const unsigned char> bytes,
                 std::uint32_t bits,
                 std::span<std::uint16_t> samples) {
  std::uint32_t kept = 0;
  std::uint32_t n_kept = 0;
  std::size_t i = 0;
  for (std::uint16_t& sample : samples) {
    while (n_kept < bits) {
      kept = kept << 8 | (i < bytes.size() ? bytes[i] : 0U);
      ++i;
      n_kept += 8;
    }
    n_kept -= bits;
    sample = static_cast<std::uint16_t>((kept >> n_kept & ((1U << bits) - 1)) << (16 - bits));
  }
}

/// Above 8 bit numbers are passed on: libtiff would make 8 bit of them.
bool read_numbers(TIFF* tiff,
                  const TiffPieces& pieces,
                  const TiffDirectory& directory,
                  Image& image) {
  const std::size_t n_samples = std::size_t{pieces.width} * directory.samples;
  const std::size_t row_bytes = (n_samples * directory.bits + 7) / 8;
  std::vector<unsigned char> piece(row_bytes * pieces.height);
  std::vector<std::uint16_t> samples(n_samples);
  std::uint32_t i_piece = 0;
  return for_each_piece(pieces, image, [&](int x, int y, int n_columns, int n_rows) {
    const auto n_bytes = static_cast<tmsize_t>(piece.size());
    const tmsize_t n_read = pieces.is_tiled
                                ? TIFFReadEncodedTile(tiff, i_piece, piece.data(), n_bytes)
                                : TIFFReadEncodedStrip(tiff, i_piece, piece.data(), n_bytes);
    ++i_piece;
    if (n_read < static_cast<tmsize_t>(row_bytes * static_cast<std::size_t>(n_rows))) return false;
    for (int i = 0; i < n_rows; ++i) {
      const auto bytes =
          std::span(piece).subspan(static_cast<std::size_t>(i) * row_bytes, row_bytes);
      if (directory.bits == 16) {
        std::memcpy(samples.data(), bytes.data(), row_bytes);
      } else {
        unpack_bits(bytes, directory.bits, samples);
      }
      copy_row(samples.data(),
               static_cast<int>(directory.samples),
               row_part(image, y + i, x, n_columns));
    }
    return true;
  });
}

bool read_tiff(TIFF* tiff,
               const PictureHeader& header,
               const TiffDirectory& directory,
               TiffInput& input,
               Image& image) {
  std::uint16_t photometric = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  if (TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric) == 0 ||
      TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width) == 0 ||
      TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height) == 0) {
    input.words += "no size or photometric interpretation\n";
    return false;
  }
  const TiffPieces pieces = pieces_of(tiff, header, directory);
  if (width != header.width || height != header.height || pieces.width == 0 || pieces.height == 0) {
    input.words += "another size than its header's\n";
    return false;
  }
  if (image.full_scale() > Image::kFullScale8) {
    std::uint16_t planes = PLANARCONFIG_CONTIG;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planes);
    if (planes != PLANARCONFIG_CONTIG && directory.samples > 1) {
      input.words += "colours of more than 8 bit in planes of their own\n";
      return false;
    }
    return read_numbers(tiff, pieces, directory, image);
  }
  std::array<char, 1024> why{};
  if (TIFFRGBAImageOK(tiff, why.data()) == 0) {
    input.words.append(why.data()).append("\n");
    return false;
  }
  const bool is_grey = photometric <= PHOTOMETRIC_MINISBLACK;
  return read_rgba(tiff, pieces, !is_grey && directory.samples == 1 && directory.bits == 1, image);
}

}  // namespace

Decoded decode_tiff(std::string_view bytes,
                    const PictureHeader& header,
                    const TiffDirectory& directory) {
  TiffInput input{.bytes = bytes};
  // Grey with transparency goes through libtiff's 8 bit.
  const bool is_deep = directory.bits > 8 && directory.samples != 2;
  Image image(static_cast<int>(header.width),
              static_cast<int>(header.height),
              is_deep ? Image::kFullScale16 : Image::kFullScale8);
  bool is_whole = false;
  if (const TiffHandle tiff = open_tiff(input)) {
    is_whole = read_tiff(tiff.get(), header, directory, input, image);
  }
  if (!is_whole || !is_harmless(input.words)) return tl::unexpected(input.words);
  return image;
}

}  // namespace panelcal::internal
