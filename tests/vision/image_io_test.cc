// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/image_io.h"

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/calib/base/random.h"

namespace panelcal {
namespace {

/// A picture with structure in 8 or 16 bit.
Image sample(double full_scale) {
  Image image(23, 17, full_scale);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      image.at(x, y) = static_cast<float>((x * 11 + y * 5 + x * y) % 256);
      if (full_scale > 255) image.at(x, y) = image.at(x, y) * 257;
    }
  }
  return image;
}

cv::Mat mat_of_sample(int type) {
  cv::Mat mat(17, 23, type);
  cv::randu(mat, 0, CV_MAT_DEPTH(type) == CV_16U ? 65535 : 255);
  return mat;
}

std::string encoded(const cv::Mat& mat, const char* extension) {
  std::vector<unsigned char> bytes;
  cv::imencode(extension, mat, bytes);
  return std::string(bytes.begin(), bytes.end());
}

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
  EXPECT_EQ(decode_image("", "a").error().text(),
            "a: error[picture-format]: the file is empty, expected PNG, TIFF, BMP or JPEG of 8 or "
            "16 bit");
  EXPECT_EQ(decode_image("GIF89a", "a").error().code, Code::PictureFormat);
  EXPECT_FALSE(encode_png(Image()).has_value());
}

/// The claim stands in the header; believing it would take 16 GB.
TEST(ImageIo, RefusesHugeClaimsBeforeAllocating) {
  std::string png = *encode_png(sample(255));
  png[17] = png[21] = 1;  // IHDR: width 65536 + 23, height 65536 + 17
  const auto read = decode_image(png, "a.png");
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().code, Code::PictureTooLarge);
  std::string bmp = encoded(mat_of_sample(CV_8UC1), ".bmp");
  bmp[20] = bmp[24] = 1;
  EXPECT_EQ(decode_image(bmp, "a.bmp").error().code, Code::PictureTooLarge);
}

TEST(ImageIo, RefusesCutOffPictures) {
  for (const char* extension : {".png", ".tiff", ".jpg"}) {
    const std::string bytes = encoded(mat_of_sample(CV_8UC1), extension);
    for (const std::size_t part : {4, 2}) {
      const auto read = decode_image(bytes.substr(0, bytes.size() * (part - 1) / part), extension);
      ASSERT_FALSE(read.has_value()) << extension << " part " << part;
      EXPECT_EQ(read.error().code, Code::PictureDamaged) << read.error().text();
    }
  }
}

/// Damaged files: an error or a picture, nothing else, and nothing on standard error.
TEST(ImageIo, AnyBytesGiveAnErrorOrAPicture) {
  constexpr std::uint64_t kSeed = 4711;
  constexpr int kVariants = 150;
  ::testing::internal::CaptureStderr();
  for (const char* extension : {".png", ".tiff", ".bmp", ".jpg"}) {
    for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1}) {
      if (CV_MAT_DEPTH(type) == CV_16U && (extension[1] == 'b' || extension[1] == 'j')) continue;
      const std::string whole = encoded(mat_of_sample(type), extension);
      Random random(kSeed);
      for (int i = 0; i < kVariants; ++i) {
        std::string bytes = whole;
        const int n_flips = 1 + static_cast<int>(random.uniform() * 4);
        for (int k = 0; k < n_flips; ++k) {
          // Half of the damage goes to the header, where it does most.
          const double end = random.uniform() < 0.5 ? 64 : static_cast<double>(bytes.size());
          const auto at = static_cast<std::size_t>(random.uniform() * end);
          bytes[std::min(at, bytes.size() - 1)] = static_cast<char>(random.uniform() * 256);
        }
        if (random.uniform() < 0.3) {
          bytes.resize(
              static_cast<std::size_t>(random.uniform() * static_cast<double>(bytes.size())));
        }
        const auto read = decode_image(bytes, extension);
        if (!read) {
          EXPECT_FALSE(read.error().what.empty());
        }
      }
    }
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace panelcal
