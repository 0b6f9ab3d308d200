// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/image_io.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/calib/base/random.h"
#include "tests/fuzz/picture_entry.h"

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

/// One entry of a TIFF directory: SHORT (3) or LONG (4), one value.
struct TiffEntry {
  std::uint32_t tag = 0;
  std::uint32_t type = 3;
  std::uint32_t value = 0;
};

/// A TIFF file of one strip or tile, written by hand so that any entry can be said.
class TiffFile {
 public:
  explicit TiffFile(std::string pixels) : pixels_(std::move(pixels)) {}

  /// Sorted by tag, as the specification asks for; the last word on a tag counts.
  TiffFile& with(TiffEntry entry) {
    const auto at = std::lower_bound(
        entries_.begin(), entries_.end(), entry.tag, [](const TiffEntry& a, std::uint32_t tag) {
          return a.tag < tag;
        });
    if (at != entries_.end() && at->tag == entry.tag) {
      *at = entry;
    } else {
      entries_.insert(at, entry);
    }
    return *this;
  }

  std::string bytes() const {
    std::string out("II*\0", 4);
    put(out, 8, 4);
    put(out, static_cast<std::uint32_t>(entries_.size()), 2);
    for (const TiffEntry& entry : entries_) {
      put(out, entry.tag, 2);
      put(out, entry.type, 2);
      put(out, 1, 4);
      const bool is_offset = entry.tag == 273 || entry.tag == 324;
      put(out, is_offset ? data_at() : entry.value, 4);
    }
    put(out, 0, 4);
    return out + pixels_;
  }

 private:
  static void put(std::string& out, std::uint32_t value, int n_bytes) {
    for (int i = 0; i < n_bytes; ++i) out += static_cast<char>(value >> (8 * i));
  }
  std::uint32_t data_at() const {
    return static_cast<std::uint32_t>(8 + 2 + 12 * entries_.size() + 4);
  }

  std::string pixels_;
  std::vector<TiffEntry> entries_;
};

/// A grey strip of 4 x 3 pixels.
TiffFile small_tiff(std::uint32_t bits, std::string pixels) {
  const auto n_bytes = static_cast<std::uint32_t>(pixels.size());
  return TiffFile(std::move(pixels))
      .with({256, 3, 4})
      .with({257, 3, 3})
      .with({258, 3, bits})
      .with({259, 3, 1})
      .with({262, 3, 1})
      .with({273, 4, 0})
      .with({277, 3, 1})
      .with({278, 3, 3})
      .with({279, 4, n_bytes});
}

constexpr std::string_view kSmall8("\x0A\x14\x1E\x28\x32\x3C\x46\x50\x5A\x64\x6E\xFF", 12);

/// The same numbers twice as wide: 0x0A0A and so on.
std::string small_16() {
  std::string pixels;
  for (const char c : kSmall8) pixels += {c, c};
  return pixels;
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

TEST(ImageIo, TiffStripsAndTilesAreRead) {
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

TEST(ImageIo, NoOrientationIsObeyed) {
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

TEST(ImageIo, TransparencyIsIgnored) {
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

TEST(ImageIo, WhiteMayBeZero) {
  const TiffEntry negative = {262, 3, 0};
  const auto grey = decode_image(small_tiff(8, std::string(kSmall8)).with(negative).bytes(), "a");
  const auto deep = decode_image(small_tiff(16, small_16()).with(negative).bytes(), "a");
  ASSERT_TRUE(grey.has_value() && deep.has_value());
  EXPECT_EQ(grey->at(1, 0), 255 - 20);
  EXPECT_EQ(deep->at(1, 0), 65535 - 20 * 257);
}

/// Packed numbers: of 12 bit, two pixels make three bytes.
TEST(ImageIo, WhiteOfFewBitsIsFullScale) {
  std::string pixels;
  for (int i = 0; i < 6; ++i) pixels += std::string("\x80\x0F\xFF", 3);
  const auto read = decode_image(small_tiff(12, pixels).bytes(), "a.tif");
  ASSERT_TRUE(read.has_value()) << read.error().text();
  EXPECT_EQ(read->full_scale(), 65535);
  EXPECT_NEAR(read->at(0, 1), 2048 * 65535.0 / 4095, 0.01);
  EXPECT_EQ(read->at(1, 1), 65535);
}

TEST(ImageIo, WhiteColorIsFullScale) {
  const cv::Mat white(3, 3, CV_8UC3, cv::Scalar::all(255));
  EXPECT_EQ(decode_image(encoded(white, ".png"), "a.png")->at(1, 1), 255);
  const cv::Mat deep(3, 3, CV_16UC3, cv::Scalar::all(65535));
  EXPECT_EQ(decode_image(encoded(deep, ".png"), "a.png")->at(1, 1), 65535);
}

TEST(ImageIo, RefusesNumbersThatAreNoLevels) {
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

/// A few bytes claim much memory: refused by the header alone.
TEST(ImageIo, RefusesClaimsThatAFileCannotHold) {
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
TEST(ImageIo, RefusesATiffThatSaysThingsTwice) {
  std::string bytes = small_tiff(8, std::string(kSmall8)).bytes();
  bytes[10 + 12] = bytes[10];  // the second entry's tag becomes the first's
  const auto read = decode_image(bytes, "a.tif");
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().code, Code::PictureDamaged);
}

TEST(ImageIo, UnknownTiffEntriesAreNoDamage) {
  const auto read = decode_image(
      small_tiff(8, std::string(kSmall8)).with({50838, 4, 12}).with({65000, 3, 1}).bytes(), "a");
  ASSERT_TRUE(read.has_value()) << read.error().text();
  EXPECT_EQ(read->at(3, 2), 255);
}

/// LZW (5) and deflate (8) that make no sense from the middle on: the decoder goes on with zeros.
TEST(ImageIo, RefusesCompressedTiffThatEndsEarly) {
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

TEST(ImageIo, RefusesAPictureCutOffAnywhere) {
  constexpr std::size_t kStep = 97;
  for (const char* extension : {".png", ".tiff", ".bmp", ".jpg"}) {
    cv::Mat mat(60, 80, CV_8UC1);
    cv::randu(mat, 0, 255);
    const std::string whole = encoded(mat, extension);
    ASSERT_GT(whole.size(), 20 * kStep);
    for (std::size_t n = 1; n + 4 < whole.size(); n += kStep) {
      const auto read = decode_image(whole.substr(0, n), extension);
      ASSERT_FALSE(read.has_value()) << extension << " cut to " << n << " of " << whole.size();
      EXPECT_EQ(fuzz::refusal_complaint(read.error()), std::nullopt) << read.error().text();
    }
  }
}

/// Every critical chunk of a PNG is under a check sum: one wrong bit and there is no picture.
TEST(ImageIo, RefusesAPngWithAnyWrongBit) {
  const std::string whole = *encode_png(sample(255));
  const Image image = sample(255);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ (1 << (i % 8)));
    const auto read = decode_image(bytes, "a.png");
    if (read) {
      EXPECT_EQ(*read, image) << "byte " << i;  // a bit of no meaning
    }
  }
}

TEST(ImageIo, FuzzSeedsAndFormerFindingsAreFine) {
  namespace fs = std::filesystem;
  const fs::path fuzz = fs::path(PANELCAL_SOURCE_DIR) / "tests" / "fuzz";
  int n = 0;
  for (const fs::path& folder : {fuzz / "corpus" / "picture", fuzz / "fixed"}) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      const auto bytes = read_file(entry.path());
      ASSERT_TRUE(bytes.has_value()) << entry.path();
      EXPECT_EQ(fuzz::run_picture(*bytes), std::nullopt) << entry.path();
      ++n;
    }
  }
  EXPECT_GT(n, 25);
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
        EXPECT_EQ(fuzz::complaint_of(read), std::nullopt) << extension << " variant " << i;
      }
    }
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace panelcal
