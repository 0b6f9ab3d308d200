// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/files/raw_pixels.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

std::vector<std::byte> words_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) {
    bytes.push_back(static_cast<std::byte>(value & 255));
    bytes.push_back(static_cast<std::byte>(value >> 8));
  }
  return bytes;
}

constexpr PixelFormat kAll[] = {PixelFormat::Mono8,
                                PixelFormat::Mono10,
                                PixelFormat::Mono12,
                                PixelFormat::Mono16,
                                PixelFormat::BayerRG8,
                                PixelFormat::BayerGR8,
                                PixelFormat::BayerGB8,
                                PixelFormat::BayerBG8,
                                PixelFormat::BayerRG16,
                                PixelFormat::BayerGR16,
                                PixelFormat::BayerGB16,
                                PixelFormat::BayerBG16,
                                PixelFormat::RGB8,
                                PixelFormat::BGR8};

TEST(RawPixels, NamesReadBack) {
  for (const PixelFormat format : kAll) {
    EXPECT_FALSE(name(format).empty());
    EXPECT_EQ(pixel_format_from_name(name(format)), format);
  }
  EXPECT_EQ(name(PixelFormat::BayerGB16), "BayerGB16");
  EXPECT_FALSE(pixel_format_from_name("Mono").has_value());
}

TEST(RawPixels, GreyNumbersAreLevels) {
  const auto mono8 = from_raw_pixels(bytes_of({0, 7, 255, 128, 1, 2}), 3, 2, PixelFormat::Mono8);
  ASSERT_TRUE(mono8.has_value());
  EXPECT_EQ(mono8->full_scale(), 255);
  EXPECT_EQ(mono8->at(2, 0), 255);
  EXPECT_EQ(mono8->at(0, 1), 128);
  const auto mono16 = from_raw_pixels(words_of({258, 65535}), 2, 1, PixelFormat::Mono16);
  ASSERT_TRUE(mono16.has_value());
  EXPECT_EQ(mono16->full_scale(), 65535);
  EXPECT_EQ(mono16->at(0, 0), 258);
  EXPECT_EQ(mono16->at(1, 0), 65535);
}

TEST(RawPixels, WhiteOfFewBitsIsFullScale) {
  for (const auto& [format, white] :
       {std::pair(PixelFormat::Mono10, 1023), std::pair(PixelFormat::Mono12, 4095)}) {
    const auto image = from_raw_pixels(words_of({white, 100}), 2, 1, format);
    ASSERT_TRUE(image.has_value());
    EXPECT_EQ(image->full_scale(), 65535);
    EXPECT_EQ(image->at(0, 0), 65535);
    EXPECT_NEAR(image->at(1, 0), 100 * 65535.0 / white, 0.01);
    const auto beyond = from_raw_pixels(words_of({white + 1}), 1, 1, format);
    ASSERT_FALSE(beyond.has_value());
    EXPECT_EQ(beyond.error().code, Code::PictureDamaged);
  }
}

TEST(RawPixels, ColorBecomesLuma) {
  const auto rgb =
      from_raw_pixels(bytes_of({200, 100, 50, 255, 255, 255}), 2, 1, PixelFormat::RGB8);
  const auto bgr =
      from_raw_pixels(bytes_of({50, 100, 200, 255, 255, 255}), 2, 1, PixelFormat::BGR8);
  ASSERT_TRUE(rgb.has_value() && bgr.has_value());
  EXPECT_NEAR(rgb->at(0, 0), 0.299 * 200 + 0.587 * 100 + 0.114 * 50, 1e-4);
  EXPECT_EQ(rgb->at(1, 0), 255);
  EXPECT_EQ(*rgb, *bgr);
}

TEST(RawPixels, BayerFormatsGoThroughTheirPattern) {
  // Red bright, green half, blue dark: only the right pattern makes it even.
  const std::vector<std::byte> rg = bytes_of({200, 100, 200, 100, 100, 0, 100, 0});
  const auto image = from_raw_pixels(rg, 4, 2, PixelFormat::BayerRG8);
  ASSERT_TRUE(image.has_value());
  for (const float level : std::as_const(*image).pixels()) EXPECT_EQ(level, 100);
  const auto red = from_raw_pixels(rg, 4, 2, PixelFormat::BayerRG8, {1, 0, 0});
  ASSERT_TRUE(red.has_value());
  for (const float level : std::as_const(*red).pixels()) EXPECT_EQ(level, 200);
  const auto deep =
      from_raw_pixels(words_of({300, 60000, 500, 300}), 2, 2, PixelFormat::BayerGR16, {1, 0, 0});
  ASSERT_TRUE(deep.has_value());
  EXPECT_EQ(deep->at(0, 0), 60000);
  const auto blue =
      from_raw_pixels(words_of({300, 60000, 500, 300}), 2, 2, PixelFormat::BayerGB16, {1, 0, 0});
  ASSERT_TRUE(blue.has_value());
  EXPECT_EQ(blue->at(0, 0), 500);
}

TEST(RawPixels, PaddingAtTheEndIsNoError) {
  EXPECT_TRUE(from_raw_pixels(bytes_of({1, 2, 3}), 2, 1, PixelFormat::Mono8).has_value());
}

TEST(RawPixels, RefusesWhatIsNoPicture) {
  for (const PixelFormat format : kAll) {
    EXPECT_EQ(from_raw_pixels({}, 0, 5, format).error().code, Code::PictureFormat);
    EXPECT_EQ(from_raw_pixels({}, 5, -1, format).error().code, Code::PictureFormat);
    const int most = std::numeric_limits<int>::max();
    EXPECT_EQ(from_raw_pixels({}, most, most, format).error().code, Code::PictureTooLarge);
    const std::vector<std::byte> bytes(20 * bytes_per_pixel(format) - 1);
    const auto read = from_raw_pixels(bytes, 5, 4, format);
    ASSERT_FALSE(read.has_value());
    EXPECT_EQ(read.error().code, Code::PictureDamaged) << read.error().text();
  }
  const auto bytes = bytes_of({1, 2, 3, 4});
  for (const ChannelGains gains :
       {ChannelGains{0, 0, 0}, ChannelGains{1, -1, 1}, ChannelGains{1, 1, std::nan("")}}) {
    EXPECT_FALSE(from_raw_pixels(bytes, 2, 2, PixelFormat::BayerRG8, gains).has_value());
  }
}

}  // namespace
}  // namespace panelcal
