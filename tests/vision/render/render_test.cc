// SPDX-License-Identifier: Apache-2.0
#include "vision/render/render.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/vision/trial.h"

namespace panelcal::test {
namespace {

Scene disc_scene(const Camera& camera) {
  Scene scene;
  scene.background = 0;
  scene.features = {disc_at(camera, 40.25, 37.5, 17.5, 0.8)};
  return scene;
}

TEST(Render, CentroidAndAreaAreThoseOfTheDisc) {
  Camera camera = plain_camera(80, 80);
  camera.full_scale = 65535;
  Random random(1);
  const Image image = render(disc_scene(camera), camera, random);
  double sum = 0;
  double sum_x = 0;
  double sum_y = 0;
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 80; ++x) {
      sum += image.at(x, y);
      sum_x += x * static_cast<double>(image.at(x, y));
      sum_y += y * static_cast<double>(image.at(x, y));
    }
  }
  // Rounding of some 200 rim pixels to 1 / 52428 of the contrast.
  EXPECT_NEAR(sum / (0.8 * 65535), 3.14159265358979 * 17.5 * 17.5, 1e-3);
  EXPECT_NEAR(sum_x / sum, 40.25, 1e-5);
  EXPECT_NEAR(sum_y / sum, 37.5, 1e-5);
}

TEST(Render, ARectangleHasItsArea) {
  Camera camera = plain_camera(80, 80);
  camera.full_scale = 65535;
  Scene scene;
  scene.background = 0;
  Feature bar;
  bar.shape = Feature::Shape::Rectangle;
  bar.center = camera.mapping(position_px(39.7, 40.2));
  bar.size = mm(0.3);
  bar.inner_size = mm(0.1);
  bar.angle = deg(30);
  bar.level = 0.5;
  scene.features = {bar};
  Random random(1);
  double sum = 0;
  const Image image = render(scene, camera, random);
  for (const float v : image.pixels()) sum += static_cast<double>(v);
  EXPECT_NEAR(sum / (0.5 * 65535), 300, 1e-2);
}

TEST(Render, EqualSeedsGiveEqualPictures) {
  Camera camera = plain_camera(60, 50);
  camera.noise = 4;
  Random first(9);
  Random second(9);
  Random third(10);
  const Image image = render(disc_scene(camera), camera, first);
  EXPECT_EQ(image, render(disc_scene(camera), camera, second));
  EXPECT_NE(image, render(disc_scene(camera), camera, third));
}

TEST(Render, NoiseHasTheSigmaAskedFor) {
  Camera camera = plain_camera(200, 200);
  camera.noise = 4;
  Scene scene;
  scene.background = 0.5;
  Random random(3);
  double sum = 0;
  double sum_squares = 0;
  const Image image = render(scene, camera, random);
  for (const float v : image.pixels()) {
    sum += static_cast<double>(v);
    sum_squares += static_cast<double>(v) * static_cast<double>(v);
  }
  const double n = 200 * 200;
  const double sigma = std::sqrt(sum_squares / n - sum * sum / n / n);
  EXPECT_NEAR(sigma, std::sqrt(16 + 1.0 / 12), 0.06);  // 4 sigma / sqrt(2 n); rounding added
}

/// The weave lies on the panel: a camera moved by 20 px sees the same, moved.
TEST(Render, OverlappingPicturesShowTheSameWeave) {
  const Camera camera = plain_camera(100, 100);
  Scene scene;
  scene.weave.amplitude = 0.1;
  Random random(1);
  const Image first = render(scene, camera, random);
  scene.weave.panel_from_optical = Transform<frame::Nominal, frame::Optical>(
      Eigen::Matrix2d::Identity(), Eigen::Vector2d(0.2, 0));
  const Image second = render(scene, camera, random);
  for (int y = 0; y < 100; ++y) {
    for (int x = 20; x < 100; ++x) EXPECT_NEAR(first.at(x, y), second.at(x - 20, y), 1);
  }
  EXPECT_NE(first, second);
}

TEST(Render, LightMultipliesEverything) {
  Camera camera = plain_camera(101, 101);
  camera.full_scale = 65535;
  Scene scene;
  scene.background = 0.5;
  scene.light_gradient = {0.2, 0};
  scene.vignetting = 0.1;
  Random random(1);
  const Image image = render(scene, camera, random);
  EXPECT_NEAR(image.at(50, 50), 0.5 * 65535, 1);
  EXPECT_GT(image.at(100, 50), image.at(0, 50));
  EXPECT_NEAR(image.at(50, 0), 0.5 * 65535 * (1 - 0.1 * 0.5 * std::pow(100.0 / 101, 2)), 1);
}

TEST(Render, FeaturesOutsideOfThePictureAreNoTrouble) {
  Camera camera = plain_camera(40, 40);
  Scene scene;
  scene.features = {disc_at(camera, -500, 20, 30, 1),
                    disc_at(camera, 20, 1e7, 30, 1),
                    disc_at(camera, 40, 20, 30, 1)};
  Random random(1);
  const Image image = render(scene, camera, random);
  EXPECT_EQ(image.at(0, 0), std::round(0.3F * 255));
  EXPECT_EQ(image.at(39, 20), 255);
}

}  // namespace
}  // namespace panelcal::test
