// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/formats/jpeg_encoder.h"

#include <csetjmp>
#include <cstddef>
#include <cstdio>  // jpeglib.h needs FILE
#include <cstdlib>

#include <jpeglib.h>

namespace panelcal::internal {
namespace {

/// libjpeg's own part comes first: it passes on a pointer to that.
struct EncoderErrors {
  jpeg_error_mgr manager{};
  std::jmp_buf jump{};
};

[[noreturn]] void leave_jpeg_encoder(j_common_ptr jpeg) {
  std::longjmp(reinterpret_cast<EncoderErrors*>(jpeg->err)->jump, 1);
}

void ignore_jpeg_message(j_common_ptr) {
}

struct JpegWriter {
  JpegWriter() {
    jpeg.err = jpeg_std_error(&errors.manager);
    errors.manager.error_exit = leave_jpeg_encoder;
    errors.manager.output_message = ignore_jpeg_message;
  }
  JpegWriter(const JpegWriter&) = delete;
  JpegWriter& operator=(const JpegWriter&) = delete;
  ~JpegWriter() {
    jpeg_destroy_compress(&jpeg);
    std::free(bytes);
  }

  jpeg_compress_struct jpeg{};
  EncoderErrors errors;
  unsigned char* bytes = nullptr;  ///< of malloc
  unsigned long n_bytes = 0;
};

/// False after an error; nothing here may need a destructor, since libjpeg jumps.
bool write_jpeg(
    JpegWriter& writer, const unsigned char* levels, int width, int height, int quality) {
  jpeg_compress_struct& jpeg = writer.jpeg;
  if (setjmp(writer.errors.jump) != 0) return false;
  jpeg_create_compress(&jpeg);
  jpeg_mem_dest(&jpeg, &writer.bytes, &writer.n_bytes);
  jpeg.image_width = static_cast<JDIMENSION>(width);
  jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = 1;
  jpeg.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  while (jpeg.next_scanline < jpeg.image_height) {
    // libjpeg reads the row, though its type does not say so.
    auto* row = const_cast<JSAMPLE*>(levels) + std::size_t{jpeg.next_scanline} * jpeg.image_width;
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  return true;
}

}  // namespace

std::string encode_grey_jpeg(std::span<const unsigned char> levels,
                             int width,
                             int height,
                             int quality) {
  JpegWriter writer;
  if (!write_jpeg(writer, levels.data(), width, height, quality)) return {};
  return {reinterpret_cast<const char*>(writer.bytes), writer.n_bytes};
}

}  // namespace panelcal::internal
