// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/overlay.h"

#include <gtest/gtest.h>

#include "panelcal/vision/image_io.h"
#include "tests/vision/trial.h"

namespace panelcal::test {
namespace {

Image disc_picture(const Camera& camera) {
  Scene scene;
  scene.features = {disc_at(camera, 70, 50, 20, 0.7)};
  Random random(1);
  return render(scene, camera, random);
}

TEST(Overlay, ShowsTheTargetEnlarged) {
  const Camera camera = plain_camera(200, 120);
  Target target;
  target.size_px = px(40);
  const Image image = disc_picture(camera);
  const Detection detection = locate(image, target);
  ASSERT_EQ(detection.status, DetectionStatus::Found);
  const auto png = encode_overlay(image, detection, {.half_width = px(30)});
  ASSERT_TRUE(png.has_value()) << png.error().text();
  const auto read = decode_image(*png, "overlay");
  ASSERT_TRUE(read.has_value()) << read.error().text();
  EXPECT_EQ(read->width(), 61 * 6);
  EXPECT_EQ(read->height(), 61 * 6);
}

TEST(Overlay, ShowsTheWholePictureIfNothingWasFound) {
  const Image image(400, 350, 65535, 30000);
  const auto png = encode_overlay(image, Detection{});
  ASSERT_TRUE(png.has_value()) << png.error().text();
  EXPECT_EQ(decode_image(*png, "overlay")->width(), 400);
}

TEST(Overlay, OddCasesAreNoTrouble) {
  EXPECT_FALSE(encode_overlay(Image(), Detection{}).has_value());
  Detection far_away;
  far_away.best.emplace();
  far_away.best->center.position = position_px(1e12, -1e12);
  far_away.best->size = px(1e9);
  EXPECT_TRUE(encode_overlay(Image(1, 1, 255, 9), far_away).has_value());
}

}  // namespace
}  // namespace panelcal::test
