// SPDX-License-Identifier: Apache-2.0
#include "vision/locate/locate.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/vision/trial.h"

namespace panelcal::test {
namespace {

constexpr double kRadius = 40;
constexpr double kLevel = 0.65;

Target disc_target() {
  Target target;
  target.size_px = px(2 * kRadius);
  return target;
}

Camera noisy_camera(int width = 480, int height = 400) {
  Camera camera = plain_camera(width, height);
  camera.noise = 3;
  return camera;
}

Image picture(const Camera& camera, std::vector<Feature> features, double weave = 0) {
  Scene scene;
  scene.features = std::move(features);
  scene.weave.amplitude = weave;
  Random random(77);
  return render(scene, camera, random);
}

std::string text(const Detection& detection) {
  return std::string(name(detection.status)) + ": " + detection.reason;
}

TEST(Locate, FindsADiscAndSaysWhatItSaw) {
  const Camera camera = noisy_camera();
  const Image image = picture(camera, {disc_at(camera, 203.37, 188.81, kRadius, kLevel)});
  const Detection detection = locate(image, disc_target());
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  const TargetFit& fit = *detection.best;
  EXPECT_NEAR(fit.center.position.in_px().x(), 203.37, 0.03);
  EXPECT_NEAR(fit.center.position.in_px().y(), 188.81, 0.03);
  EXPECT_NEAR(fit.size.in_px(), 2 * kRadius, 0.05);
  EXPECT_NEAR(fit.blur_px, 1.04, 0.05);
  EXPECT_NEAR(fit.background, 0.3 * 255, 1);
  EXPECT_NEAR(fit.contrast, 0.35 * 255, 1);
  EXPECT_NEAR(fit.noise, 3, 0.3);
  EXPECT_EQ(fit.excluded, 0);
  EXPECT_GT(fit.score, 0.95);
  EXPECT_FALSE(fit.center_optical.has_value());
  EXPECT_EQ(detection.n_candidates, 1);
  EXPECT_EQ(detection.reason, "");
}

TEST(Locate, GivesMillimetresWithAMapping) {
  const Camera camera = noisy_camera();
  const Feature disc = disc_at(camera, 203.37, 188.81, kRadius, kLevel);
  Target target;
  target.size = disc.size;
  const Detection detection = locate(picture(camera, {disc}), target, &camera.mapping);
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  const auto& center = *detection.best->center_optical;
  EXPECT_LT((center.position - disc.center).in_mm().norm(), 0.0003);
  EXPECT_NEAR(detection.best->size_mm->in_mm(), disc.size.in_mm(), 0.0005);
}

TEST(Locate, NeighboursOfOtherSizesDoNotMatter) {
  const Camera camera = noisy_camera();
  const Image image = picture(camera,
                              {disc_at(camera, 240, 200, kRadius, kLevel),
                               disc_at(camera, 330, 200, kRadius * 0.8, kLevel),
                               disc_at(camera, 120, 200, kRadius * 1.4, kLevel),
                               disc_at(camera, 240, 300, kRadius * 1.1, kLevel)});
  const Detection detection = locate(image, disc_target());
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  EXPECT_LT((detection.best->center.position - position_px(240, 200)).in_px().norm(), 0.05);
}

TEST(Locate, TwoEqualDiscsAreAmbiguous) {
  const Camera camera = noisy_camera();
  const Image image = picture(
      camera,
      {disc_at(camera, 140, 200, kRadius, kLevel), disc_at(camera, 340, 180, kRadius, kLevel)});
  Detection detection = locate(image, disc_target());
  EXPECT_EQ(detection.status, DetectionStatus::Ambiguous) << text(detection);
  EXPECT_EQ(detection.n_candidates, 2);
  EXPECT_NE(detection.reason, "");

  LocateOptions options;
  options.search_center = position_px(330, 190);
  options.search_radius = px(60);
  detection = locate(image, disc_target(), nullptr, options);
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  EXPECT_NEAR(detection.best->center.position.in_px().x(), 340, 0.1);
}

TEST(Locate, FindsNothingWhereNothingIs) {
  const Camera camera = noisy_camera();
  for (const double weave : {0.0, 0.03, 0.08}) {
    const Detection detection = locate(picture(camera, {}, weave), disc_target());
    EXPECT_EQ(detection.status, DetectionStatus::NotFound) << "weave " << weave << text(detection);
    EXPECT_FALSE(detection.best.has_value());
    EXPECT_NE(detection.reason, "");
  }
}

TEST(Locate, WrongPolarityIsNotFound) {
  const Camera camera = noisy_camera();
  const Image image = picture(camera, {disc_at(camera, 240, 200, kRadius, kLevel)});
  Target target = disc_target();
  target.polarity = Polarity::Dark;
  const Detection detection = locate(image, target);
  EXPECT_EQ(detection.status, DetectionStatus::NotFound) << text(detection);
}

TEST(Locate, WrongSizeIsRejectedWithTheSizeSeen) {
  const Camera camera = noisy_camera();
  const Image image = picture(camera, {disc_at(camera, 240, 200, 1.07 * kRadius, kLevel)});
  const Detection detection = locate(image, disc_target());
  EXPECT_EQ(detection.status, DetectionStatus::Rejected) << text(detection);
  EXPECT_EQ(detection.reason, "its size is 85.6 px, +7.0 % from 80; 4.0 % are allowed");
}

TEST(Locate, MuchTooSmallOrLargeIsNotFound) {
  const Camera camera = noisy_camera();
  for (const double factor : {0.5, 2.0}) {
    const Image image = picture(camera, {disc_at(camera, 240, 200, factor * kRadius, kLevel)});
    const Detection detection = locate(image, disc_target());
    EXPECT_NE(detection.status, DetectionStatus::Found) << factor;
    EXPECT_NE(detection.status, DetectionStatus::Ambiguous) << factor;
    EXPECT_NE(detection.reason, "");
  }
}

TEST(Locate, ADiscIsNoRingButAPadMayHaveAHole) {
  const Camera camera = noisy_camera();
  Feature ring = disc_at(camera, 240, 200, kRadius, kLevel);
  ring.shape = Feature::Shape::Ring;
  ring.inner_size = 0.6 * ring.size;
  Target ring_target = disc_target();
  ring_target.shape = Shape::Ring;
  ring_target.inner_size_px = px(0.6 * 2 * kRadius);

  const Image of_ring = picture(camera, {ring});
  const Image of_disc = picture(camera, {disc_at(camera, 240, 200, kRadius, kLevel)});
  const Detection found = locate(of_ring, ring_target);
  EXPECT_EQ(found.status, DetectionStatus::Found) << text(found);
  EXPECT_NEAR(found.best->inner_size->in_px(), 0.6 * 2 * kRadius, 0.1);
  const Detection disc_as_ring = locate(of_disc, ring_target);
  EXPECT_NE(disc_as_ring.status, DetectionStatus::Found);
  const Detection ring_as_disc = locate(of_ring, disc_target());
  EXPECT_EQ(ring_as_disc.status, DetectionStatus::Found) << text(ring_as_disc);
  EXPECT_LT((ring_as_disc.best->center.position - position_px(240, 200)).in_px().norm(), 0.03);
}

TEST(Locate, AtTheBorderIsRejectedAndSaysSo) {
  const Camera camera = noisy_camera();
  const Image cut = picture(camera, {disc_at(camera, 25, 200, kRadius, kLevel)});
  Detection detection = locate(cut, disc_target());
  EXPECT_EQ(detection.status, DetectionStatus::Rejected) << text(detection);
  EXPECT_TRUE(detection.reason.starts_with("at the border")) << detection.reason;

  const Image half = picture(camera, {disc_at(camera, -2, 200, kRadius, kLevel)});
  detection = locate(half, disc_target());
  EXPECT_TRUE(detection.status == DetectionStatus::Rejected ||
              detection.status == DetectionStatus::NotFound);
  EXPECT_NE(detection.reason, "");
}

TEST(Locate, DebrisIsLeftOutAndReported) {
  const Camera camera = noisy_camera();
  Feature chip = disc_at(camera, 272, 222, 7, 0.05);
  const Image image = picture(camera, {disc_at(camera, 240, 200, kRadius, kLevel), chip});
  const Detection detection = locate(image, disc_target());
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  EXPECT_GT(detection.best->excluded, 0.005);
  const Eigen::Vector2d error = (detection.best->center.position - position_px(240, 200)).in_px();
  EXPECT_LT(error.norm(), 0.05);
}

TEST(Locate, SaturatedDiscIsFoundWhereItIs) {
  Camera camera = noisy_camera();
  const Image image = picture(camera, {disc_at(camera, 240.3, 200.6, kRadius, 1.3)});
  const Detection detection = locate(image, disc_target());
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  EXPECT_NEAR(detection.best->center.position.in_px().x(), 240.3, 0.03);
  EXPECT_NEAR(detection.best->center.position.in_px().y(), 200.6, 0.03);
}

/// A bar over a part of a disc's rim: nothing but background is seen there.
Feature cover(const Camera& camera, double x, double width) {
  Feature bar = disc_at(camera, x, 200, 100, 0.3);
  bar.shape = Feature::Shape::Rectangle;
  bar.inner_size = mm(0.01 * width);
  bar.angle = deg(90);
  return bar;
}

TEST(Locate, OnlyAnArcIsRejected) {
  const Camera camera = noisy_camera();
  // From x = 250 on the disc of radius 40 is covered: acos(0.25) / pi = 0.42 of its rim.
  const Image image =
      picture(camera, {disc_at(camera, 240, 200, kRadius, kLevel), cover(camera, 280, 60)});
  const Detection detection = locate(image, disc_target());
  EXPECT_EQ(detection.status, DetectionStatus::Rejected) << text(detection);
  EXPECT_TRUE(detection.reason.starts_with("only an arc is visible")) << text(detection);
}

/// A rim's parts that are spread around say as much of its centre as a longer arc.
TEST(Locate, FindsADiscWithMarksAllAroundItsRim) {
  const Camera camera = noisy_camera();
  std::vector<Feature> features = {disc_at(camera, 240, 200, kRadius, kLevel)};
  constexpr int kBars = 8;
  for (int i = 0; i < kBars; ++i) {
    const double phi = 2 * std::numbers::pi * i / kBars;
    Feature bar =
        disc_at(camera, 240 + kRadius * std::cos(phi), 200 + kRadius * std::sin(phi), 12, 0.3);
    bar.shape = Feature::Shape::Rectangle;
    bar.inner_size = mm(0.01 * 10);
    bar.angle = rad(-phi);  // y is up there
    features.push_back(bar);
  }
  const Detection detection = locate(picture(camera, features), disc_target());
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  const auto& center = detection.best->center;
  EXPECT_LT((center.position - position_px(240, 200)).in_px().norm(), 0.06);
  EXPECT_LT(std::sqrt(center.cov(0, 0)), 0.06);
  // Bars 10 px wide cover 80 px of 251.
  EXPECT_LT(detection.best->visible, LocateOptions{}.min_visible);
}

/// The opening's edge is stronger than the pad's, and 6 px farther out.
TEST(Locate, FindsThePadInAMasksOpening) {
  const Camera camera = noisy_camera();
  const Image image = picture(camera,
                              {disc_at(camera, 241, 199.5, kRadius + 6, 0.55),
                               disc_at(camera, 240.3, 199.7, kRadius, kLevel)});
  const Detection detection = locate(image, disc_target());
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  EXPECT_LT((detection.best->center.position - position_px(240.3, 199.7)).in_px().norm(), 0.15);
  EXPECT_NEAR(detection.best->size.in_px(), 2 * kRadius, 0.5);
}

/// An opening 3.2 px wide and 1 px off: one broad edge at a glance, nearer to the rim on one side.
TEST(Locate, FindsThePadInANarrowOpeningThatIsOff) {
  const Camera camera = noisy_camera();
  for (const Eigen::Vector2d& off : {Eigen::Vector2d(0.9, -0.4), Eigen::Vector2d(-0.2, 1)}) {
    const Image image =
        picture(camera,
                {disc_at(camera, 240.3 + off.x(), 199.7 + off.y(), kRadius + 3.2, 0.5),
                 disc_at(camera, 240.3, 199.7, kRadius, kLevel)});
    const Detection detection = locate(image, disc_target());
    ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
    const auto& center = detection.best->center;
    const Eigen::Vector2d error = (center.position - position_px(240.3, 199.7)).in_px();
    EXPECT_LT(error.norm(), 0.1);
    EXPECT_LT(std::sqrt(error.dot(center.cov.inverse() * error)), 4);
    EXPECT_NEAR(detection.best->size.in_px(), 2 * kRadius, 0.5);
  }
}

TEST(Locate, APadOfAnotherSizeIsStillRejected) {
  const Camera camera = noisy_camera();
  const Image image = picture(camera,
                              {disc_at(camera, 241, 199.5, kRadius + 8, 0.5),
                               disc_at(camera, 240.3, 199.7, kRadius + 3.5, kLevel)});
  const Detection detection = locate(image, disc_target());
  EXPECT_EQ(detection.status, DetectionStatus::Rejected) << text(detection);
  EXPECT_TRUE(detection.reason.starts_with("its size is")) << text(detection);
}

TEST(Locate, OutOfFocusIsRejected) {
  Camera camera = noisy_camera();
  camera.blur_px = 8;
  const Detection detection =
      locate(picture(camera, {disc_at(camera, 240, 200, kRadius, kLevel)}), disc_target());
  EXPECT_EQ(detection.status, DetectionStatus::Rejected) << text(detection);
  EXPECT_TRUE(detection.reason.starts_with("out of focus")) << text(detection);
}

TEST(Locate, ATiltedBoardsDiscIsOval) {
  Camera camera = noisy_camera();
  camera.tilt = deg(14);
  const double ratio = std::cos(camera.tilt.in_rad());
  const Image image = picture(camera, {disc_at(camera, 239.5, 199.5, kRadius, kLevel)});
  const Detection refused = locate(image, disc_target());
  EXPECT_EQ(refused.status, DetectionStatus::Rejected);
  EXPECT_NE(refused.reason.find("(max_oval)"), std::string::npos) << refused.reason;
  const Detection detection = locate(image, disc_target(), nullptr, {.max_oval = 0.04});
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  EXPECT_NEAR(detection.best->axis_ratio, ratio, 0.003);
  EXPECT_LT((detection.best->center.position - position_px(239.5, 199.5)).in_px().norm(), 0.03);
}

TEST(Locate, ARingsHoleMayBeOffCentre) {
  const Camera camera = noisy_camera();
  Feature ring = disc_at(camera, 240.2, 200.7, kRadius, kLevel);
  ring.shape = Feature::Shape::Ring;
  ring.inner_size = 0.5 * ring.size;
  ring.hole_offset = displacement_mm<frame::Optical>(Eigen::Vector2d(0.04, 0.03));
  Target target = disc_target();
  target.shape = Shape::Ring;
  const Detection detection = locate(picture(camera, {ring}), target);
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  EXPECT_LT((detection.best->center.position - position_px(240.2, 200.7)).in_px().norm(), 0.05);
  // The picture's y is down.
  EXPECT_LT((detection.best->hole_offset_px - Eigen::Vector2d(4, -3)).norm(), 0.1);
}

TEST(Locate, AHoleIsADarkDisc) {
  const Camera camera = noisy_camera();
  Target target = disc_target();
  target.shape = Shape::Hole;
  target.polarity = Polarity::Dark;
  const Image image = picture(camera, {disc_at(camera, 240.4, 200.1, kRadius, 0.02)});
  const Detection detection = locate(image, target);
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  EXPECT_LT((detection.best->center.position - position_px(240.4, 200.1)).in_px().norm(), 0.05);
}

TEST(Locate, AReflectionOnTheTargetDoesNotMoveIt) {
  const Camera camera = noisy_camera();
  Image image = picture(camera, {disc_at(camera, 240, 200, kRadius, kLevel)});
  // Over the flat part and the rim alike, by the disc's own share of each pixel.
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double t = (kRadius - std::hypot(x - 240, y - 200)) / 1.04;
      const double share = 0.5 * std::erfc(-t / std::numbers::sqrt2);
      image.at(x, y) += static_cast<float>(share * 15 * (x - 240) / kRadius);
    }
  }
  const Detection detection = locate(image, disc_target());
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  EXPECT_LT((detection.best->center.position - position_px(240, 200)).in_px().norm(), 0.04);
}

TEST(Locate, HostilePicturesAndSizesAreNeverFound) {
  for (const double full : {255.0, 65535.0}) {
    for (const int side : {1, 3, 9, 40, 150}) {
      for (int pattern = 0; pattern < 4; ++pattern) {
        Image image(side, side, full);
        for (int y = 0; y < side; ++y) {
          for (int x = 0; x < side; ++x) {
            const bool is_on = pattern == 1 || (pattern == 2 && (x + y) % 2 == 0) ||
                               (pattern == 3 && (x / 8 + y / 8) % 2 == 0);
            image.at(x, y) = is_on ? static_cast<float>(full) : 0;
          }
        }
        for (const double diameter : {0.1, 6.0, 16.0, 300.0, 2e10, 1e300}) {
          Target target;
          target.size_px = px(diameter);
          const Detection detection = locate(image, target);
          EXPECT_NE(detection.status, DetectionStatus::Found)
              << side << " " << pattern << " " << diameter;
        }
      }
    }
  }
}

TEST(Locate, OddPicturesAreNoTrouble) {
  for (const auto& [width, height] : {std::pair{0, 0}, {1, 1}, {3, 200}, {200, 2}, {30, 30}}) {
    for (const float level : {0.0F, 100.0F, 255.0F}) {
      const Detection detection = locate(Image(width, height, 255, level), disc_target());
      EXPECT_EQ(detection.status, DetectionStatus::NotFound) << width << " x " << height;
    }
  }
  Target tiny = disc_target();
  tiny.size_px = px(0.5);
  EXPECT_EQ(locate(Image(50, 50, 255, 10), tiny).status, DetectionStatus::NotFound);
  Target huge = disc_target();
  huge.size_px = px(1e7);
  EXPECT_EQ(locate(Image(50, 50, 255, 10), huge).status, DetectionStatus::NotFound);
}

TEST(Locate, PerfectPictureStillHasAnError) {
  const Camera camera = plain_camera(200, 200);
  const Detection detection =
      locate(picture(camera, {disc_at(camera, 99.4, 101.1, kRadius, kLevel)}), disc_target());
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  EXPECT_GT(detection.best->center.cov(0, 0), 1e-7);
}

TEST(Locate, BadRequestsAreRejectedWithTheReason) {
  const Image image(100, 100, 255, 10);
  Target in_mm;
  in_mm.size = mm(1);
  EXPECT_EQ(text(locate(image, in_mm)), "rejected: a size in mm needs a camera mapping");
  EXPECT_NE(locate(image, Target{}).reason.find("missing key \"size_mm\""), std::string::npos);
  LocateOptions options;
  options.min_score = 2;
  EXPECT_NE(locate(image, disc_target(), nullptr, options).reason.find("min_score = 2"),
            std::string::npos);
  options = {};
  options.search_radius = px(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(locate(image, disc_target(), nullptr, options).status, DetectionStatus::Rejected);
}

TEST(Locate, EqualPicturesGiveEqualAnswers) {
  const Camera camera = noisy_camera();
  const Image image = picture(camera, {disc_at(camera, 203.37, 188.81, kRadius, kLevel)}, 0.03);
  const Detection first = locate(image, disc_target());
  const Detection second = locate(image, disc_target());
  ASSERT_EQ(first.status, DetectionStatus::Found);
  EXPECT_EQ(first.best->center.position, second.best->center.position);
  EXPECT_EQ(first.best->center.cov, second.best->center.cov);
}

}  // namespace
}  // namespace panelcal::test
