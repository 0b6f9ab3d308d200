// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/files/image_io.h"

#include <filesystem>
#include <string>
#include <string_view>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/matchers.h"
#include "tests/vision/picture/bytes.h"

namespace panelcal {
namespace {

using test::encoded;
using test::mat_of_sample;
using test::sample;

TEST(ImageIo, PngReadsBackExactly) {
  for (const double full_scale : {255.0, 65535.0}) {
    const Image image = sample(full_scale);
    const auto png = encode_png(image);
    ASSERT_TRUE(png.has_value());
    const auto read = decode_image(*png, "a.png");
    ASSERT_TRUE(read.has_value()) << read.error().text();
    EXPECT_EQ(*read, image);
  }
}

TEST(ImageIo, JpegsOfLargePicturesAreSmaller) {
  // Quadrants that no compression of 8 x 8 pixels mixes; one row and column are left over.
  Image image(1601, 801, Image::kFullScale16, 20 * 257);
  for (int y = 0; y < 801; ++y) {
    for (int x = 800; x < 1601; ++x) image.at(x, y) = 200 * 257;
  }
  const auto jpeg = encode_jpeg(image, 800);
  ASSERT_TRUE(jpeg.has_value()) << jpeg.error().text();
  const auto read = decode_image(*jpeg, "a.jpg");
  ASSERT_TRUE(read.has_value()) << read.error().text();
  // 1601 px in at most 800: by 3.
  EXPECT_EQ(read->width(), 533);
  EXPECT_EQ(read->height(), 267);
  EXPECT_NEAR(read->at(100, 100), 20, 2);
  EXPECT_NEAR(read->at(400, 100), 200, 2);

  const auto whole = encode_jpeg(image, 1601);
  ASSERT_TRUE(whole.has_value());
  EXPECT_EQ(decode_image(*whole, "a.jpg")->width(), 1601);
  EXPECT_EQ(encode_jpeg(Image(), 800).error().code, Code::PictureFormat);
}

TEST(ImageIo, WritesAndReadsFiles) {
  const auto path = std::filesystem::path(::testing::TempDir()) / "image_io_test.png";
  ASSERT_TRUE(write_png(path, sample(255)).has_value());
  const auto read = read_image(path);
  ASSERT_TRUE(read.has_value()) << read.error().text();
  EXPECT_EQ(*read, sample(255));
  std::filesystem::remove(path);
  EXPECT_EQ(read_image(path).error().code, Code::FileUnreadable);
}

TEST(ImageIo, ReadsEveryKindAndDepth) {
  for (const char* extension : {".png", ".tiff", ".bmp"}) {
    const cv::Mat mat = mat_of_sample(CV_8UC1);
    const auto read = decode_image(encoded(mat, extension), extension);
    ASSERT_TRUE(read.has_value()) << read.error().text();
    EXPECT_EQ(read->at(5, 3), mat.at<unsigned char>(3, 5)) << extension;
  }
  const cv::Mat deep = mat_of_sample(CV_16UC1);
  const auto tiff = decode_image(encoded(deep, ".tiff"), "a.tiff");
  ASSERT_TRUE(tiff.has_value()) << tiff.error().text();
  EXPECT_EQ(tiff->full_scale(), 65535);
  EXPECT_EQ(tiff->at(7, 8), deep.at<unsigned short>(8, 7));
  const auto jpeg =
      decode_image(encoded(cv::Mat(17, 23, CV_8UC1, cv::Scalar(90)), ".jpg"), "a.jpg");
  ASSERT_TRUE(jpeg.has_value()) << jpeg.error().text();
  EXPECT_NEAR(jpeg->at(3, 3), 90, 2);
}

TEST(ImageIo, ColorBecomesLuma) {
  const cv::Mat red(4, 4, CV_8UC3, cv::Scalar(0, 0, 200));
  EXPECT_NEAR(decode_image(encoded(red, ".png"), "a.png")->at(1, 1), 0.299 * 200, 0.01);
  const cv::Mat green(4, 4, CV_16UC4, cv::Scalar(0, 60000, 0, 65535));
  EXPECT_NEAR(decode_image(encoded(green, ".png"), "a.png")->at(1, 1), 0.587 * 60000, 5);
}

TEST(ImageIo, RefusesFloatingPointPixels) {
  const cv::Mat mat(4, 4, CV_32FC1, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  const auto read = decode_image(encoded(mat, ".tiff"), "a.tiff");
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().code, Code::PictureFormat);
}

TEST(ImageIo, RefusesWhatIsNoPicture) {
  EXPECT_EQ(test::brief(decode_image("", "a").error()), "a: error[picture-format]");
  EXPECT_EQ(decode_image("GIF89a", "a").error().code, Code::PictureFormat);
  EXPECT_FALSE(encode_png(Image()).has_value());
}

TEST(ImageIo, WhiteColorIsFullScale) {
  const cv::Mat white(3, 3, CV_8UC3, cv::Scalar::all(255));
  EXPECT_EQ(decode_image(encoded(white, ".png"), "a.png")->at(1, 1), 255);
  const cv::Mat deep(3, 3, CV_16UC3, cv::Scalar::all(65535));
  EXPECT_EQ(decode_image(encoded(deep, ".png"), "a.png")->at(1, 1), 65535);
}

TEST(ImageIo, RefusesOtherKindsThatTheLibraryWouldRead) {
  const cv::Mat mat = mat_of_sample(CV_8UC3);
  for (const char* extension : {".pgm", ".ppm", ".pam", ".webp", ".ras"}) {
    std::string bytes;
    try {
      bytes =
          encoded(extension == std::string_view(".pgm") ? mat_of_sample(CV_8UC1) : mat, extension);
    } catch (const cv::Exception&) {
      continue;  // built without it
    }
    const auto read = decode_image(bytes, extension);
    ASSERT_FALSE(read.has_value()) << extension;
    EXPECT_EQ(read.error().code, Code::PictureFormat) << read.error().text();
  }
  for (const std::string_view start : {"NITF02.10", "GIF89a", "II+", "%PDF-1.4", "#?RADIANCE\n"}) {
    const auto read = decode_image(std::string(start) + std::string(200, '\0'), "a");
    ASSERT_FALSE(read.has_value()) << start;
    EXPECT_EQ(read.error().code, Code::PictureFormat) << read.error().text();
  }
}

}  // namespace
}  // namespace panelcal
