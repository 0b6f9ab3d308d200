// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "vision/picture/files/image_io.h"
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/vision/picture/bytes.h"
#include "tests/vision/picture/formats/tiff_file.h"

namespace panelcal {
namespace {

using test::encoded;
using test::kSmall8;
using test::mat_of_sample;
using test::small_16;
using test::small_tiff;
using test::TiffEntry;
using test::TiffFile;

TEST(TiffReading, TiffStripsAndTilesAreRead) {
  const auto strip = decode_image(small_tiff(8, std::string(kSmall8)).bytes(), "a.tif");
  ASSERT_TRUE(strip.has_value()) << strip.error().text();
  EXPECT_EQ(strip->at(1, 2), 100);
  std::string tile(16 * 16 * 2, '\0');
  tile[2 * (16 * 2 + 1)] = 7;
  tile[2 * (16 * 2 + 1) + 1] = 1;
  const auto tiled = decode_image(TiffFile(tile)
                                      .with({256, 3, 4})
                                      .with({257, 3, 3})
                                      .with({258, 3, 16})
                                      .with({259, 3, 1})
                                      .with({262, 3, 1})
                                      .with({277, 3, 1})
                                      .with({322, 3, 16})
                                      .with({323, 3, 16})
                                      .with({324, 4, 0})
                                      .with({325, 4, 512})
                                      .bytes(),
                                  "a.tif");
  ASSERT_TRUE(tiled.has_value()) << tiled.error().text();
  EXPECT_EQ(tiled->at(1, 2), 256 + 7);
}

TEST(TiffReading, NoOrientationIsObeyed) {
  for (std::uint32_t orientation = 1; orientation <= 8; ++orientation) {
    const TiffEntry turned = {274, 3, orientation};
    const auto grey = decode_image(small_tiff(8, std::string(kSmall8)).with(turned).bytes(), "a");
    const auto deep = decode_image(small_tiff(16, small_16()).with(turned).bytes(), "a");
    ASSERT_TRUE(grey.has_value() && deep.has_value()) << orientation;
    EXPECT_EQ(grey->width(), 4) << orientation;
    for (const auto& [x, y, level] : {std::array{0, 0, 10}, {3, 0, 40}, {0, 2, 90}}) {
      EXPECT_EQ(grey->at(x, y), level) << orientation;
      EXPECT_EQ(deep->at(x, y), level * 257) << orientation;
    }
  }
}

TEST(TiffReading, TransparencyIsIgnored) {
  const std::string pixels("\x0A\x14\x1E\x00\x32\x3C\x46\x50\x5A\x64\x6E\x00", 12);
  for (const std::uint32_t kind_of_alpha : {0, 1, 2}) {
    // Three grey levels with transparency: 1 x 3 RGBA pixels.
    const auto read = decode_image(TiffFile(pixels)
                                       .with({256, 3, 1})
                                       .with({257, 3, 3})
                                       .with({258, 3, 8})
                                       .with({259, 3, 1})
                                       .with({262, 3, 2})
                                       .with({273, 4, 0})
                                       .with({277, 3, 4})
                                       .with({278, 3, 3})
                                       .with({279, 4, 12})
                                       .with({284, 3, 1})
                                       .with({338, 3, kind_of_alpha})
                                       .bytes(),
                                   "a.tif");
    ASSERT_TRUE(read.has_value()) << read.error().text();
    EXPECT_NEAR(read->at(0, 0), 0.299 * 10 + 0.587 * 20 + 0.114 * 30, 0.01);
    EXPECT_NEAR(read->at(0, 1), 0.299 * 50 + 0.587 * 60 + 0.114 * 70, 0.01);
  }
  const cv::Mat clear(4, 4, CV_8UC4, cv::Scalar(80, 80, 80, 0));
  EXPECT_EQ(decode_image(encoded(clear, ".png"), "a.png")->at(2, 2), 80);
}

TEST(TiffReading, WhiteMayBeZero) {
  const TiffEntry negative = {262, 3, 0};
  const auto grey = decode_image(small_tiff(8, std::string(kSmall8)).with(negative).bytes(), "a");
  const auto deep = decode_image(small_tiff(16, small_16()).with(negative).bytes(), "a");
  ASSERT_TRUE(grey.has_value() && deep.has_value());
  EXPECT_EQ(grey->at(1, 0), 255 - 20);
  EXPECT_EQ(deep->at(1, 0), 65535 - 20 * 257);
}

/// Packed numbers: of 12 bit, two pixels make three bytes.
TEST(TiffReading, WhiteOfFewBitsIsFullScale) {
  std::string pixels;
  for (int i = 0; i < 6; ++i) pixels += std::string("\x80\x0F\xFF", 3);
  const auto read = decode_image(small_tiff(12, pixels).bytes(), "a.tif");
  ASSERT_TRUE(read.has_value()) << read.error().text();
  EXPECT_EQ(read->full_scale(), 65535);
  EXPECT_NEAR(read->at(0, 1), 2048 * 65535.0 / 4095, 0.01);
  EXPECT_EQ(read->at(1, 1), 65535);
}

TEST(TiffReading, RefusesNumbersThatAreNoLevels) {
  const std::string words(4 * 12, '\x7F');  // as floating-point numbers: NaN
  for (const std::uint32_t sample_format : {2, 3}) {
    for (const std::uint32_t bits : {8, 16, 32, 64}) {
      const auto read = decode_image(
          small_tiff(bits, words + words).with({339, 3, sample_format}).bytes(), "a.tif");
      ASSERT_FALSE(read.has_value()) << bits;
      EXPECT_EQ(read.error().code, Code::PictureFormat) << read.error().text();
    }
  }
  for (const std::uint32_t bits : {0, 2, 4, 7, 24, 32, 64, 65535}) {
    const auto read = decode_image(small_tiff(bits, words + words).bytes(), "a.tif");
    ASSERT_FALSE(read.has_value()) << bits;
    EXPECT_EQ(read.error().code, Code::PictureFormat) << read.error().text();
  }
  for (const int type : {CV_32FC1, CV_64FC1, CV_32SC1, CV_16SC1}) {
    for (const double level : {std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::infinity(),
                               1e300}) {
      const auto read = decode_image(encoded(cv::Mat(4, 4, type, cv::Scalar(level)), ".tiff"), "a");
      ASSERT_FALSE(read.has_value()) << type;
      EXPECT_EQ(read.error().code, Code::PictureFormat) << read.error().text();
    }
  }
}

/// A few bytes claim much memory: refused by the header alone.
TEST(TiffReading, RefusesClaimsThatAFileCannotHold) {
  for (const auto& [width, height] : {std::pair(10'000U, 10'000U), {3'000U, 3'000U}}) {
    const auto read = decode_image(small_tiff(8, std::string(kSmall8))
                                       .with({256, 4, width})
                                       .with({257, 4, height})
                                       .with({278, 4, height})
                                       .bytes(),
                                   "a.tif");
    ASSERT_FALSE(read.has_value());
    EXPECT_EQ(read.error().code, Code::PictureDamaged);
    EXPECT_NE(read.error().text().find("pixels a byte"), std::string::npos) << read.error().text();
  }
  const auto tile = decode_image(
      small_tiff(8, std::string(kSmall8)).with({322, 4, 1U << 15}).with({323, 4, 1U << 14}).bytes(),
      "a.tif");
  ASSERT_FALSE(tile.has_value());
  EXPECT_NE(tile.error().text().find("tiles of 32768 x 16384"), std::string::npos)
      << tile.error().text();
  // A picture of one level is as small as files get, and is read.
  const auto even = decode_image(encoded(cv::Mat(3000, 4000, CV_8UC1, cv::Scalar(9)), ".png"), "a");
  ASSERT_TRUE(even.has_value()) << even.error().text();
  EXPECT_EQ(even->at(3999, 2999), 9);
}

/// The decoder believes one of them, panelcal the other.
TEST(TiffReading, RefusesATiffThatSaysThingsTwice) {
  std::string bytes = small_tiff(8, std::string(kSmall8)).bytes();
  bytes[10 + 12] = bytes[10];  // the second entry's tag becomes the first's
  const auto read = decode_image(bytes, "a.tif");
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().code, Code::PictureDamaged);
}

TEST(TiffReading, UnknownTiffEntriesAreNoDamage) {
  const auto read = decode_image(
      small_tiff(8, std::string(kSmall8)).with({50838, 4, 12}).with({65000, 3, 1}).bytes(), "a");
  ASSERT_TRUE(read.has_value()) << read.error().text();
  EXPECT_EQ(read->at(3, 2), 255);
}

/// LZW (5) and deflate (8) that make no sense from the middle on: the decoder goes on with zeros.
TEST(TiffReading, RefusesCompressedTiffThatEndsEarly) {
  constexpr std::size_t kTail = 60;
  for (const int compression : {5, 8}) {
    std::vector<unsigned char> bytes;
    cv::imencode(
        ".tiff", mat_of_sample(CV_8UC1), bytes, {cv::IMWRITE_TIFF_COMPRESSION, compression});
    const std::string whole(bytes.begin(), bytes.end());
    ASSERT_TRUE(decode_image(whole, "whole").has_value()) << compression;
    // OpenCV puts the pixels first, from byte 8.
    std::string damaged = whole;
    std::fill_n(damaged.begin() + 8 + kTail, kTail, '\xFF');
    const auto read = decode_image(damaged, "damaged");
    ASSERT_FALSE(read.has_value()) << compression;
    EXPECT_EQ(read.error().code, Code::PictureDamaged) << read.error().text();
  }
}

}  // namespace
}  // namespace panelcal
