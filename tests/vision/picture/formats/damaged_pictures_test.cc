// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "calib/base/files/atomic_file.h"
#include "calib/base/statistics/random.h"
#include "vision/picture/files/image_io.h"
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/fuzz/picture_entry.h"
#include "tests/support/folders.h"
#include "tests/vision/picture/bytes.h"

namespace panelcal {
namespace {

using test::encoded;
using test::mat_of_sample;
using test::sample;

/// The claim stands in the header; believing it would take 16 GB.
TEST(DamagedPictures, RefusesHugeClaimsBeforeAllocating) {
  std::string png = *encode_png(sample(255));
  png[17] = png[21] = 1;  // IHDR: width 65536 + 23, height 65536 + 17
  const auto read = decode_image(png, "a.png");
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().code, Code::PictureTooLarge);
  std::string bmp = encoded(mat_of_sample(CV_8UC1), ".bmp");
  bmp[20] = bmp[24] = 1;
  EXPECT_EQ(decode_image(bmp, "a.bmp").error().code, Code::PictureTooLarge);
}

TEST(DamagedPictures, RefusesCutOffPictures) {
  for (const char* extension : {".png", ".tiff", ".jpg"}) {
    const std::string bytes = encoded(mat_of_sample(CV_8UC1), extension);
    for (const std::size_t part : {4, 2}) {
      const auto read = decode_image(bytes.substr(0, bytes.size() * (part - 1) / part), extension);
      ASSERT_FALSE(read.has_value()) << extension << " part " << part;
      EXPECT_EQ(read.error().code, Code::PictureDamaged) << read.error().text();
    }
  }
}

TEST(DamagedPictures, RefusesAPictureCutOffAnywhere) {
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
TEST(DamagedPictures, RefusesAPngWithAnyWrongBit) {
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

TEST(DamagedPictures, FuzzSeedsAndFormerFindingsAreFine) {
  namespace fs = std::filesystem;
  const fs::path fuzz = test::source_folder() / "tests" / "fuzz";
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
TEST(DamagedPictures, AnyBytesGiveAnErrorOrAPicture) {
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
          bytes[std::min(at, bytes.size() - 1)] =
              static_cast<char>(static_cast<int>(random.uniform() * 256));
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
