// SPDX-License-Identifier: Apache-2.0
// Our decoders beside OpenCV's, which read pictures before: the same levels, and the same bytes of
// what is written.
#include "vision/picture/formats/decoder.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "vision/picture/files/image_io.h"
#include "vision/picture/formats/tiff_directory.h"
#include "vision/picture/luma.h"
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/folders.h"
#include "tests/vision/picture/bytes.h"
#include "tests/vision/picture/formats/tiff_file.h"

namespace panelcal {
namespace {

using test::encoded;

template <class Number>
float level_of(const cv::Mat& mat, int x, int y) {
  const auto* at = mat.ptr<Number>(y) + x * mat.channels();
  return mat.channels() == 1 ? static_cast<float>(at[0]) : internal::luma(at[0], at[1], at[2]);
}

/// OpenCV's reading. Of TIFF only what needs no finishing: no orientation, 0 is black, no alpha (by
/// which OpenCV multiplies the levels; see tiff_reading_test.cc).
Image read_by_opencv(const std::string& bytes) {
  const std::vector<unsigned char> input(bytes.begin(), bytes.end());
  const cv::Mat mat = cv::imdecode(input, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
  const bool is_deep = mat.depth() == CV_16U;
  Image image(mat.cols, mat.rows, is_deep ? Image::kFullScale16 : Image::kFullScale8);
  for (int y = 0; y < mat.rows; ++y) {
    for (int x = 0; x < mat.cols; ++x) {
      image.at(x, y) =
          is_deep ? level_of<std::uint16_t>(mat, x, y) : level_of<std::uint8_t>(mat, x, y);
    }
  }
  return image;
}

void expect_same(const std::string& bytes, const std::string& name) {
  const auto read = decode_image(bytes, name);
  ASSERT_TRUE(read.has_value()) << read.error().text();
  EXPECT_EQ(*read, read_by_opencv(bytes)) << name;
}

cv::Mat noise(int rows, int columns, int type) {
  cv::Mat mat(rows, columns, type);
  cv::randu(mat, 0, CV_MAT_DEPTH(type) == CV_16U ? 65536 : 256);
  return mat;
}

TEST(Decoder, ReadsWhatOpenCvWrites) {
  for (const char* extension : {".png", ".tiff", ".bmp", ".jpg"}) {
    const std::string kind = extension;
    for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3, CV_16UC4}) {
      const bool is_deep = CV_MAT_DEPTH(type) == CV_16U;
      if (is_deep && (kind == ".bmp" || kind == ".jpg")) continue;
      if (CV_MAT_CN(type) == 4 && (kind == ".jpg" || kind == ".tiff")) continue;
      for (const int side : {1, 7, 64}) {
        expect_same(encoded(noise(side, side + 6, type), extension),
                    kind + " of type " + std::to_string(type));
      }
    }
  }
}

TEST(Decoder, ReadsEveryKindOfFileThatTheFuzzerBeginsWith) {
  namespace fs = std::filesystem;
  int n = 0;
  for (const auto& entry :
       fs::directory_iterator(test::source_folder() / "tests/fuzz/corpus/picture")) {
    const std::string bytes = *read_file(entry.path());
    const auto directory = internal::tiff_directory(bytes);
    const bool is_finished =
        directory && internal::without_orientation_and_alpha(bytes, *directory).has_value();
    if (is_finished || !decode_image(bytes, "a")) continue;
    expect_same(bytes, entry.path().filename().string());
    ++n;
  }
  EXPECT_GE(n, 20);
}

std::string little_endian(std::uint32_t number, int n_bytes) {
  std::string bytes;
  for (int i = 0; i < n_bytes; ++i) bytes += static_cast<char>(i < 4 ? number >> (8 * i) : 0);
  return bytes;
}

struct Bmp {
  std::uint32_t width = 13;
  std::int32_t height = 9;
  std::uint32_t bits = 8;
  std::uint32_t compression = 0;
  std::string tables = {};  ///< masks or palette
  std::string pixels = {};

  std::string bytes() const {
    const auto begin = static_cast<std::uint32_t>(54 + tables.size());
    return "BM" + little_endian(begin, 4) + little_endian(0, 4) + little_endian(begin, 4) +
           little_endian(40, 4) + little_endian(width, 4) +
           little_endian(static_cast<std::uint32_t>(height), 4) + little_endian(1, 2) +
           little_endian(bits, 2) + little_endian(compression, 4) + little_endian(0, 20) + tables +
           pixels;
  }
};

std::string any_bytes(std::size_t n) {
  std::string bytes;
  for (std::size_t i = 0; i < n; ++i) bytes += static_cast<char>(i * 89 + i / 7 * 31 + 5);
  return bytes;
}

TEST(Decoder, ReadsEveryBmp) {
  for (const std::uint32_t bits : {1, 4, 8, 16, 24, 32}) {
    for (const int height : {9, -9}) {
      Bmp bmp{.height = height, .bits = bits};
      if (bits <= 8) bmp.tables = any_bytes(std::size_t{4} << bits);
      bmp.pixels = any_bytes((bmp.width * bits + 31) / 32 * 4 * 9);
      expect_same(bmp.bytes(), std::to_string(bits) + " bit");
      bmp.pixels.pop_back();
      EXPECT_EQ(decode_image(bmp.bytes(), "a").error().code, Code::PictureDamaged);
    }
  }
}

TEST(Decoder, ReadsBmpOfSixteenBitWithEitherMask) {
  for (const auto& [red, green] : {std::pair(0x7C00U, 0x3E0U), {0xF800U, 0x7E0U}}) {
    const std::string masks =
        little_endian(red, 4) + little_endian(green, 4) + little_endian(0x1F, 4);
    expect_same(
        Bmp{.bits = 16, .compression = 3, .tables = masks, .pixels = any_bytes(28 * 9)}.bytes(),
        "masks");
  }
}

/// Runs, single pixels, a skipped rest of a row and skipped rows.
TEST(Decoder, ReadsBmpWithRuns) {
  using namespace std::string_literals;
  const std::string palette8 = any_bytes(1024);
  const std::string palette4 = any_bytes(64);
  for (const std::string& pixels :
       {"\x05\x07\x00\x04\x01\x02\x03\x04\x04\x09\x00\x00\x0D\x21\x00\x01"s,
        "\x05\x07\x00\x00\x02\x08\x00\x02\x03\x02\x04\x05\x00\x01"s,
        "\x03\x07\x00\x01"s}) {
    expect_same(Bmp{.bits = 8, .compression = 1, .tables = palette8, .pixels = pixels}.bytes(),
                "runs of 8 bit");
  }
  std::string rows;
  for (int y = 0; y < 9; ++y) rows += "\x05\x17\x00\x05\x12\x34\x50\x00\x03\x42\x00\x00"s;
  expect_same(
      Bmp{.bits = 4, .compression = 2, .tables = palette4, .pixels = rows + "\x00\x01"s}.bytes(),
      "runs of 4 bit");
  const Bmp endless{.bits = 8, .compression = 1, .tables = palette8, .pixels = "\x05\x07\x00\x00"s};
  EXPECT_EQ(decode_image(endless.bytes(), "a").error().code, Code::PictureDamaged);
  const Bmp too_wide{
      .bits = 8, .compression = 1, .tables = palette8, .pixels = "\x0E\x07\x00\x01"s};
  EXPECT_EQ(decode_image(too_wide.bytes(), "a").error().code, Code::PictureDamaged);
}

TEST(Decoder, RefusesATiffWhosePixelsOfManyBitsAreCutOff) {
  std::string pixels = test::small_16();
  pixels.resize(pixels.size() - 2);
  const auto read = decode_image(test::small_tiff(16, pixels).bytes(), "a.tif");
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().code, Code::PictureDamaged) << read.error().text();
}

/// Reports and synthetic pictures keep their bytes.
TEST(Encoder, WritesTheBytesThatOpenCvWrites) {
  for (const double full_scale : {Image::kFullScale8, Image::kFullScale16}) {
    Image image(61, 43, full_scale);
    for (float& level : image.pixels()) {
      level = static_cast<float>(cv::theRNG().uniform(-5.0, full_scale + 5));
    }
    const cv::Mat view(43, 61, CV_32FC1, image.pixels().data());
    cv::Mat mat;
    view.convertTo(mat, full_scale > Image::kFullScale8 ? CV_16U : CV_8U);
    EXPECT_EQ(*encode_png(image), encoded(mat, ".png"));
  }
}

}  // namespace
}  // namespace panelcal
