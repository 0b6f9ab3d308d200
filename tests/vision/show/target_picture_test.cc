// SPDX-License-Identifier: Apache-2.0
#include "vision/show/target_picture.h"

#include <cmath>
#include <string>

#include "vision/picture/files/image_io.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

/// A dark square of 21 px about (60, 40) on a bright ground.
Image square() {
  Image image(120, 80, Image::kFullScale8, 200);
  for (int y = 30; y <= 50; ++y) {
    for (int x = 50; x <= 70; ++x) image.row(y)[x] = 40;
  }
  return image;
}

Detection found() {
  Detection detection;
  detection.status = DetectionStatus::Found;
  TargetFit& best = detection.best.emplace();
  best.center = {position_px(60, 40), 1e-4 * Eigen::Matrix2d::Identity()};
  best.size = px(20);
  best.contrast = -160;
  best.outlines_px = {{{50, 30}, {70, 30}, {70, 50}, {50, 50}}};
  Candidate other;
  other.center = position_px(60, 40);
  detection.candidates.push_back(other);
  other.center = position_px(20, 20);
  other.size = px(6);
  other.reason = "too small";
  detection.candidates.push_back(other);
  return detection;
}

TEST(TargetPicture, IsThePieceAroundTheTarget) {
  const TargetPicture piece = target_picture(square(), found()).value();
  const Image image = decode_image(piece.jpeg, "piece").value();
  EXPECT_EQ(image.width(), piece.width_px);
  EXPECT_EQ(image.height(), piece.height_px);
  EXPECT_LT(image.width(), 80);
  // Its pixels are those of the picture, but for what JPEG loses.
  const int x = static_cast<int>(std::lround(60 - piece.left_px - 0.5));
  const int y = static_cast<int>(std::lround(40 - piece.top_px - 0.5));
  EXPECT_NEAR(image.row(y)[x], 40, 6);
  EXPECT_NEAR(image.row(1)[1], 200, 6);
}

TEST(TargetPicture, SaysWhatWasFoundAndWhatElseWasLookedAt) {
  const TargetPicture piece = target_picture(square(), found()).value();
  EXPECT_EQ(piece.center_px, Eigen::Vector2d(60, 40));
  EXPECT_EQ(piece.cov_px2(0, 0), 1e-4);
  EXPECT_NEAR(piece.contrast, -160.0 / 255, 1e-12);
  ASSERT_EQ(piece.outlines_px.size(), 1);
  EXPECT_EQ(piece.outlines_px[0].size(), 4);
  ASSERT_EQ(piece.others.size(), 1) << "the best one is no other";
  EXPECT_EQ(piece.others[0].reason, "too small");
}

TEST(TargetPicture, OfNothingIsTheWholePictureMadeSmall) {
  const TargetPicture piece = target_picture(Image(1200, 600, 65535, 65535), {}).value();
  EXPECT_FALSE(piece.center_px);
  EXPECT_EQ(piece.left_px, -0.5);
  EXPECT_EQ(piece.width_px, 1200);
  const Image image = decode_image(piece.jpeg, "piece").value();
  EXPECT_EQ(image.width(), TargetPicture::kMaxSide_px);
  EXPECT_EQ(image.height(), TargetPicture::kMaxSide_px / 2);
  EXPECT_NEAR(image.row(5)[5], 255, 2);
  EXPECT_LT(piece.jpeg.size(), 5000U);
}

TEST(TargetPicture, RefusesAnEmptyPicture) {
  EXPECT_EQ(target_picture(Image(), {}).error().code, Code::PictureFormat);
}

}  // namespace
}  // namespace panelcal
