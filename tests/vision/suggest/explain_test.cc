// SPDX-License-Identifier: Apache-2.0
#include "vision/suggest/explain.h"

#include <string>

#include "vision/locate/locate.h"
#include <gtest/gtest.h>

#include "tests/vision/suggest/drawn.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;

Image picture_with_disc(double diameter_px, float level, double full_scale = Image::kFullScale8) {
  Image image(200, 160, full_scale, static_cast<float>(100 * full_scale / 255));
  test::draw(image, test::disc_of(diameter_px), {102.3, 80.4}, level);
  test::add_noise(image, 0.004 * full_scale, 9);
  return image;
}

Target disc_target(double size_px, Polarity polarity) {
  Target target;
  target.size_px = px(size_px);
  target.polarity = polarity;
  return target;
}

bool tells(const Detection& detection, const std::string& words) {
  return detection.reason.find(words) != std::string::npos;
}

TEST(Explain, TellsOfOtherPolarityAndSize) {
  const Detection detection = locate(picture_with_disc(61, 200), disc_target(80, Polarity::Dark));
  EXPECT_NE(detection.status, DetectionStatus::Found);
  EXPECT_TRUE(tells(detection, "is a bright disc of 6")) << detection.reason;
  EXPECT_TRUE(tells(detection, "where a dark disc of 80.0 px was asked for: polarity and size"))
      << detection.reason;
}

TEST(Explain, GivesTheRatioOfSizes) {
  const Detection detection = locate(picture_with_disc(60, 200), disc_target(40, Polarity::Bright));
  EXPECT_NE(detection.status, DetectionStatus::Found);
  ASSERT_TRUE(detection.size_ratio.has_value()) << detection.reason;
  EXPECT_NEAR(*detection.size_ratio, 1.5, 0.03);
}

TEST(Explain, LooksWhereTheTargetIsSearchedOnly) {
  LocateOptions options;
  options.search_center = position_px<frame::Image>(Vector2d(30, 30));
  options.search_radius = px(20);
  const Detection detection =
      locate(picture_with_disc(60, 200), disc_target(30, Polarity::Dark), nullptr, options);
  EXPECT_FALSE(tells(detection, "bright disc")) << detection.reason;
}

TEST(Explain, KnowsTwelveBitsInSixteen) {
  Image image = picture_with_disc(60, 200);
  Image deep(image.width(), image.height(), Image::kFullScale16);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) deep.at(x, y) = 16 * image.at(x, y);
  }
  const Detection detection = locate(deep, disc_target(60, Polarity::Bright));
  EXPECT_NE(detection.status, DetectionStatus::Found);
  EXPECT_TRUE(
      tells(detection, "the picture uses 1/16 of its range: 12 bit in 16? set [camera] bits"))
      << detection.reason;
}

TEST(Explain, IsSilentAboutEmptyPictures) {
  const Detection detection =
      locate(Image(100, 80, Image::kFullScale8, 90), disc_target(30, Polarity::Bright));
  EXPECT_EQ(detection.reason, "nothing like the target is in the searched area");
}

}  // namespace
}  // namespace panelcal
