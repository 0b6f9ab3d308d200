// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdio>  // jpeglib.h needs FILE
#include <utility>
#include <vector>

#include "vision/picture/formats/decoder.h"
#include "vision/picture/formats/sample_row.h"
#include <jpeglib.h>

namespace panelcal::internal {
namespace {

/// libjpeg's own part comes first: it passes on a pointer to that.
struct JpegErrors {
  jpeg_error_mgr manager{};
  std::jmp_buf jump{};
  std::array<char, JMSG_LENGTH_MAX> words{};  ///< the first message
};

void note_jpeg_message(j_common_ptr jpeg) {
  auto* errors = reinterpret_cast<JpegErrors*>(jpeg->err);
  if (errors->words[0] == '\0') errors->manager.format_message(jpeg, errors->words.data());
}

[[noreturn]] void fail_jpeg(j_common_ptr jpeg) {
  note_jpeg_message(jpeg);
  std::longjmp(reinterpret_cast<JpegErrors*>(jpeg->err)->jump, 1);
}

struct JpegReader {
  JpegReader() {
    jpeg.err = jpeg_std_error(&errors.manager);
    errors.manager.error_exit = fail_jpeg;
    errors.manager.output_message = note_jpeg_message;
  }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
  ~JpegReader() { jpeg_destroy_decompress(&jpeg); }

  jpeg_decompress_struct jpeg{};
  JpegErrors errors;
};

/// False after an error; as below, nothing here may need a destructor, since libjpeg jumps.
bool begin_jpeg(JpegReader& reader, std::string_view bytes) {
  jpeg_decompress_struct& jpeg = reader.jpeg;
  if (setjmp(reader.errors.jump) != 0) return false;
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&jpeg, TRUE);
  jpeg.out_color_space = jpeg.num_components == 1   ? JCS_GRAYSCALE
                         : jpeg.num_components == 4 ? JCS_CMYK
                                                    : JCS_RGB;
  jpeg_start_decompress(&jpeg);
  return true;
}

/// Cyan, magenta, yellow and black, as Photoshop writes them turned around, in place to RGB.
void cmyk_to_rgb(unsigned char* samples, std::size_t n_pixels) {
  for (std::size_t i = 0; i < n_pixels; ++i, samples += 4) {
    const int black = samples[3];
    for (std::size_t k = 0; k < 3; ++k) {
      samples[k] = static_cast<unsigned char>(black - ((255 - samples[k]) * black >> 8));
    }
  }
}

bool read_jpeg_rows(JpegReader& reader, std::vector<unsigned char>& row, Image& image) {
  jpeg_decompress_struct& jpeg = reader.jpeg;
  if (setjmp(reader.errors.jump) != 0) return false;
  for (int y = 0; y < image.height(); ++y) {
    unsigned char* samples = row.data();
    if (jpeg_read_scanlines(&jpeg, &samples, 1) != 1) return false;
    if (jpeg.out_color_space == JCS_CMYK) cmyk_to_rgb(samples, jpeg.output_width);
    copy_row(samples, jpeg.output_components, image.row(y));
  }
  jpeg_finish_decompress(&jpeg);
  return true;
}

}  // namespace

Decoded decode_jpeg(std::string_view bytes, const PictureHeader& header) {
  JpegReader reader;
  const auto words = [&] { return tl::unexpected<std::string>(reader.errors.words.data()); };
  if (!begin_jpeg(reader, bytes)) return words();
  if (reader.jpeg.output_width != header.width || reader.jpeg.output_height != header.height) {
    return tl::unexpected<std::string>("another size than its header's");
  }
  Image image(static_cast<int>(header.width), static_cast<int>(header.height), Image::kFullScale8);
  std::vector<unsigned char> row(static_cast<std::size_t>(reader.jpeg.output_width) *
                                 static_cast<std::size_t>(reader.jpeg.output_components));
  // Warnings too: after them libjpeg goes on with pixels of its own.
  if (!read_jpeg_rows(reader, row, image) || reader.errors.words[0] != '\0') return words();
  return image;
}

}  // namespace panelcal::internal
