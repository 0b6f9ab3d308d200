// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/formats/png_codec.h"

#include <algorithm>
#include <bit>
#include <csetjmp>
#include <cstdint>
#include <exception>
#include <string_view>
#include <utility>
#include <vector>

#include "vision/picture/formats/decoder.h"
#include "vision/picture/formats/plain_png.h"
#include "vision/picture/formats/sample_row.h"
#include <png.h>
#include <zlib.h>

namespace panelcal::internal {
namespace {

/// State that a struct of libpng calls back with.
struct PngState {
  std::string_view input;
  std::string output;
  std::string words;
};

[[noreturn]] void fail_png(png_structp png, png_const_charp words) {
  auto* state = static_cast<PngState*>(png_get_error_ptr(png));
  state->words = words;
  png_longjmp(png, 1);
}

/// Warnings are of anything but pixels: those are under check sums.
void ignore_png_warning(png_structp /*png*/, png_const_charp /*words*/) {
}

void read_png_bytes(png_structp png, png_bytep to, png_size_t n) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  if (n > state->input.size()) png_error(png, "the file is cut off");
  std::copy_n(state->input.data(), n, reinterpret_cast<char*>(to));
  state->input.remove_prefix(n);
}

void write_png_bytes(png_structp png, png_bytep bytes, png_size_t n) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  bool is_kept = true;
  try {
    state->output.append(reinterpret_cast<const char*>(bytes), n);
  } catch (const std::exception&) {  // must not fly through C
    is_kept = false;
  }
  if (!is_kept) png_error(png, "out of memory");
}

void flush_png(png_structp /*png*/) {
}

struct PngReader {
  explicit PngReader(std::string_view bytes) {
    state.input = bytes;
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &state, fail_png, ignore_png_warning);
    if (png != nullptr) info = png_create_info_struct(png);
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }

  PngState state;
  png_structp png = nullptr;
  png_infop info = nullptr;
  int n_passes = 1;
};

/// False after an error; as below, nothing here may need a destructor, since libpng jumps.
bool begin_png(PngReader& reader) {
  png_structp png = reader.png;
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_read_fn(png, &reader.state, read_png_bytes);
  png_read_info(png, reader.info);
  const int color = png_get_color_type(png, reader.info);
  const int bits = png_get_bit_depth(png, reader.info);
  if (bits == 16 && std::endian::native == std::endian::little) png_set_swap(png);
  if (color == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  if (color == PNG_COLOR_TYPE_GRAY && bits < 8) png_set_expand_gray_1_2_4_to_8(png);
  png_set_strip_alpha(png);
  reader.n_passes = png_set_interlace_handling(png);
  png_read_update_info(png, reader.info);
  return true;
}

bool read_png_rows(PngReader& reader, std::vector<unsigned char>& rows, Image& image) {
  png_structp png = reader.png;
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  const int n_channels = png_get_channels(png, reader.info);
  const std::size_t stride = reader.n_passes > 1 ? png_get_rowbytes(png, reader.info) : 0;
  for (int pass = 0; pass < reader.n_passes; ++pass) {
    for (int y = 0; y < image.height(); ++y) {
      unsigned char* row = rows.data() + stride * static_cast<std::size_t>(y);
      png_read_row(png, row, nullptr);
      if (pass + 1 < reader.n_passes) continue;
      if (image.full_scale() > Image::kFullScale8) {
        copy_row(reinterpret_cast<const std::uint16_t*>(row), n_channels, image.row(y));
      } else {
        copy_row(row, n_channels, image.row(y));
      }
    }
  }
  png_read_end(png, nullptr);
  return true;
}

struct PngWriter {
  PngWriter() {
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &state, fail_png, ignore_png_warning);
    if (png != nullptr) info = png_create_info_struct(png);
  }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter() { png_destroy_write_struct(&png, &info); }

  PngState state;
  png_structp png = nullptr;
  png_infop info = nullptr;
};

bool write_png_pixels(PngWriter& writer, const PngPixels& pixels) {
  png_structp png = writer.png;
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, &writer.state, write_png_bytes, flush_png);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_set_compression_level(png, Z_BEST_SPEED);
  png_set_compression_strategy(png, Z_RLE);
  png_set_IHDR(png,
               writer.info,
               static_cast<png_uint_32>(pixels.width),
               static_cast<png_uint_32>(pixels.height),
               pixels.bits,
               pixels.n_channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, writer.info);
  png_set_bgr(png);
  if (pixels.bits == 16 && std::endian::native == std::endian::little) png_set_swap(png);
  for (int y = 0; y < pixels.height; ++y) {
    png_write_row(png, pixels.first_row + y * pixels.row_bytes);
  }
  png_write_end(png, writer.info);
  return true;
}

}  // namespace

Decoded decode_png(std::string_view bytes, const PictureHeader& header) {
  if (auto image = read_plain_png(bytes)) return *std::move(image);
  return decode_by_libpng(bytes, header);
}

Decoded decode_by_libpng(std::string_view bytes, const PictureHeader& header) {
  PngReader reader(bytes);
  if (reader.info == nullptr) return tl::unexpected<std::string>("out of memory");
  if (!begin_png(reader)) return tl::unexpected(std::move(reader.state.words));
  if (png_get_image_width(reader.png, reader.info) != header.width ||
      png_get_image_height(reader.png, reader.info) != header.height) {
    return tl::unexpected<std::string>("another size than its header's");
  }
  const bool is_deep = png_get_bit_depth(reader.png, reader.info) == 16;
  Image image(static_cast<int>(header.width),
              static_cast<int>(header.height),
              is_deep ? Image::kFullScale16 : Image::kFullScale8);
  const auto n_rows = static_cast<std::size_t>(reader.n_passes > 1 ? image.height() : 1);
  std::vector<unsigned char> rows(n_rows * png_get_rowbytes(reader.png, reader.info));
  if (!read_png_rows(reader, rows, image)) return tl::unexpected(std::move(reader.state.words));
  return image;
}

tl::expected<std::string, std::string> encode_png_pixels(const PngPixels& pixels) {
  PngWriter writer;
  if (writer.info == nullptr) return tl::unexpected<std::string>("out of memory");
  if (!write_png_pixels(writer, pixels)) return tl::unexpected(std::move(writer.state.words));
  return std::move(writer.state.output);
}

}  // namespace panelcal::internal
