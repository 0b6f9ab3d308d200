// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "vision/locate/locate.h"
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/vision/tag/peers.h"
#include "tests/vision/tag/trial.h"

namespace panelcal::test {
namespace {

constexpr double kSide = 120;
/// Five sigmas of a corner in the pictures here, about; ten times less than the library's errors.
constexpr double kNear = 0.03;

Target tag_target(std::string family = "tag36h11", double side_px = kSide) {
  Target target;
  target.shape = Shape::AprilTag;
  target.size_px = px(side_px);
  target.size_tolerance = 0.2;  // tilt makes sides shorter
  target.tag_family = std::move(family);
  return target;
}

TagScene scene_of(std::string_view family, int id) {
  TagScene scene;
  scene.pattern = *tag_pattern(family, id);
  scene.width = 320;
  scene.height = 240;
  return scene;
}

/// A tag that lies straight, its middle at a place of the picture.
Eigen::Matrix3d straight(double x_px, double y_px, double side_px = kSide) {
  Eigen::Matrix3d pose;
  pose << side_px, 0, x_px, 0, side_px, y_px, 0, 0, 1;
  return pose;
}

Image picture_of(const TagScene& scene, std::uint64_t seed = 1) {
  Random random(seed);
  return tag_picture(scene, random);
}

/// Two tags in one picture, which do not overlap.
Image picture_of(const TagScene& a, const TagScene& b) {
  Image image = picture_of(a, 1);
  const Image other = picture_of(b, 2);
  for (std::size_t i = 0; i < image.pixels().size(); ++i) {
    const double around = a.around;
    const bool is_other =
        std::abs(other.pixels()[i] - around) > std::abs(image.pixels()[i] - around);
    if (is_other) image.pixels()[i] = other.pixels()[i];
  }
  return image;
}

std::string text(const Detection& detection) {
  return std::string(name(detection.status)) + ": " + detection.reason;
}

void expect_at(const Detection& detection, const TagScene& scene, int id, double near_px) {
  ASSERT_EQ(detection.status, DetectionStatus::Found) << text(detection);
  const TargetFit& fit = *detection.best;
  EXPECT_EQ(fit.tag_id, id);
  EXPECT_LT((fit.center.position.in_px() - scene.center_px()).norm(), near_px);
  ASSERT_EQ(fit.corners.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT((fit.corners[i].position.in_px() - scene.corners_px()[i]).norm(), 2 * near_px) << i;
  }
}

TEST(TagDetector, MiddleOfAPixelIsAWholeNumber) {
  TagScene scene = scene_of("tag36h11", 3);
  scene.width = scene.height = 201;
  scene.noise = 0;
  scene.image_from_tag = straight(100, 100);
  const Image image = picture_of(scene);
  const Detection detection = locate(image, tag_target());
  expect_at(detection, scene, 3, 1e-3);
  // The library counts that pixel's middle as (100.5, 100.5), and its edge is known to us only to
  // a few hundredths. Corrected by half a pixel it must agree.
  const auto library = library_tag(image, "tag36h11", 3);
  ASSERT_TRUE(library);
  EXPECT_LT((library->center_px - Eigen::Vector2d(100, 100)).norm(), 0.1);
}

TEST(TagDetector, CornersHaveTheOrderOfTheLibrary) {
  TagScene scene = scene_of("tag36h11", 11);
  for (int i = 0; i < 3; ++i) {
    Random random = Random(3).fork(static_cast<std::uint64_t>(i));
    scene.image_from_tag = random_pose(scene, 100, 0.3, random);
    const Image image = picture_of(scene);
    const auto library = library_tag(image, "tag36h11", 11);
    const Detection detection = locate(image, tag_target("tag36h11", 100));
    ASSERT_TRUE(library);
    expect_at(detection, scene, 11, kNear);
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector2d ours = detection.best->corners[k].position.in_px();
      EXPECT_LT((ours - library->corners_px[k]).norm(), 0.3) << i << " " << k;
    }
  }
}

TEST(TagDetector, FindsEveryFamilyInAnyPose) {
  for (const std::string_view name : tag_family_names()) {
    const TagFamily family = *find_tag_family(name);
    for (const int id : {0, family.n_tags() - 1}) {
      TagScene scene = scene_of(name, id);
      scene.width = scene.height = 240;
      const double side_px = 130.0 * family.n_on_side / family.n_cells;
      Random random = Random(17).fork(static_cast<std::uint64_t>(id));
      scene.light_gradient = {0.3, -0.2};
      scene.image_from_tag = random_pose(scene, side_px, 0.5, random);
      SCOPED_TRACE(std::string(name) + " " + std::to_string(id));
      const Target target = tag_target(std::string(name), side_px);
      expect_at(locate(picture_of(scene), target), scene, id, kNear);
    }
  }
}

TEST(TagDetector, CenterIsWhereDiagonalsMeet) {
  TagScene scene = scene_of("tag36h11", 5);
  scene.noise = 0;
  Eigen::Matrix3d pose = straight(160, 120);
  pose(2, 0) = 0.25;  // strongly foreshortened
  scene.image_from_tag = pose;
  const Detection detection = locate(picture_of(scene), tag_target());
  expect_at(detection, scene, 5, 0.01);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& corner : detection.best->corners) mean += corner.position.in_px() / 4;
  EXPECT_GT((mean - scene.center_px()).norm(), 1);
}

TEST(TagDetector, AngleIsThatOfItsLowerSide) {
  TagScene scene = scene_of("tag25h9", 8);
  const double turn = 2.1;
  Eigen::Matrix3d pose = Eigen::Matrix3d::Identity();
  pose.topLeftCorner<2, 2>() = kSide * Eigen::Rotation2Dd(turn).toRotationMatrix();
  pose.topRightCorner<2, 1>() << 161.3, 118.2;
  scene.image_from_tag = pose;
  const Detection detection = locate(picture_of(scene), tag_target("tag25h9"));
  expect_at(detection, scene, 8, kNear);
  const double error = std::remainder(detection.best->angle.in_rad() - turn, 2 * std::numbers::pi);
  EXPECT_GT(detection.best->angle_sigma.in_rad(), 0);
  EXPECT_LT(std::abs(error), 5 * detection.best->angle_sigma.in_rad());
  EXPECT_NEAR(detection.best->size.in_px(), kSide, kNear);
}

TEST(TagDetector, WithACameraItTellsMillimetresUpwards) {
  const CameraMapping mapping(
      {.scale_mm_per_px = 0.02, .rotation_rad = 0.1, .axis_px = {150, 130}, .k1_per_px2 = 0});
  TagScene scene = scene_of("tag36h11", 20);
  scene.image_from_tag = straight(170.2, 110.9);
  Target target = tag_target();
  target.size_px.reset();
  target.size = mm(kSide * 0.02);
  target.size_tolerance = 0.01;
  const Detection detection = locate(picture_of(scene), target, &mapping);
  expect_at(detection, scene, 20, kNear);
  const TargetFit& fit = *detection.best;
  const auto truth = mapping(position_px<frame::Image>(scene.center_px()));
  EXPECT_LT((fit.center_optical->position - truth).in_mm().norm(), 0.02 * kNear);
  EXPECT_NEAR(fit.size_mm->in_mm(), kSide * 0.02, 0.02 * kNear);
  EXPECT_NEAR(fit.angle.in_rad(), 0.1, 1e-3);
}

TEST(TagDetector, InvertedTagsAreDarkOnes) {
  TagScene scene = scene_of("tag36h11", 9);
  std::swap(scene.black, scene.white);
  scene.image_from_tag = straight(160, 120);
  const Image image = picture_of(scene);
  EXPECT_EQ(locate(image, tag_target()).status, DetectionStatus::NotFound);
  Target dark = tag_target();
  dark.polarity = Polarity::Dark;
  const Detection detection = locate(image, dark);
  expect_at(detection, scene, 9, kNear);
  EXPECT_NEAR(detection.best->contrast, -140, 1);
}

TEST(TagDetector, OfSeveralTagsTheIdDecides) {
  TagScene a = scene_of("tag36h11", 4);
  a.image_from_tag = straight(80, 120, 90);
  TagScene b = scene_of("tag36h11", 40);
  b.image_from_tag = straight(230, 120, 90);
  const Image image = picture_of(a, b);
  Target target = tag_target("tag36h11", 90);
  const Detection any = locate(image, target);
  EXPECT_EQ(any.status, DetectionStatus::Ambiguous) << text(any);
  EXPECT_EQ(any.n_candidates, 2);
  target.tag_id = 40;
  expect_at(locate(image, target), b, 40, kNear);
  target.tag_id = 41;
  const Detection other = locate(image, target);
  EXPECT_EQ(other.status, DetectionStatus::Rejected);
  EXPECT_EQ(other.reason, "it is tag 4, 41 is asked for");
  EXPECT_EQ(other.n_candidates, 0);
}

TEST(TagDetector, WrongSizesAreRejected) {
  TagScene scene = scene_of("tag36h11", 2);
  scene.image_from_tag = straight(160, 120, 110);
  Target target = tag_target();
  target.size_tolerance = 0.04;
  const Detection detection = locate(picture_of(scene), target);
  EXPECT_EQ(detection.status, DetectionStatus::Rejected);
  EXPECT_EQ(detection.reason, "its size is 110 px, -8.3 % from 120; 4.0 % are allowed");
}

TEST(TagDetector, LeavingThePictureIsRejectedOrUnseen) {
  TagScene scene = scene_of("tag36h11", 2);
  // The quiet zone may leave the picture, the tag may not.
  scene.image_from_tag = straight(61.5, 120);
  expect_at(locate(picture_of(scene), tag_target()), scene, 2, kNear);
  for (const double x : {59.0, 55.0, 50.0, 40.0, 10.0}) {
    scene.image_from_tag = straight(x, 120);
    EXPECT_NE(locate(picture_of(scene), tag_target()).status, DetectionStatus::Found) << x;
  }
}

TEST(TagDetector, FaintAndBlurredTagsAreNotMeasured) {
  TagScene scene = scene_of("tag36h11", 2);
  scene.image_from_tag = straight(160, 120);
  scene.noise = 1;
  scene.white = scene.black + 10;
  scene.around = scene.black + 5;
  EXPECT_EQ(locate(picture_of(scene), tag_target()).status, DetectionStatus::NotFound);
  scene = scene_of("tag36h11", 2);
  scene.image_from_tag = straight(160, 120);
  scene.blur_px = 10;  // two thirds of a cell
  EXPECT_NE(locate(picture_of(scene), tag_target()).status, DetectionStatus::Found);
}

TEST(TagDetector, SearchAreaIsKept) {
  TagScene scene = scene_of("tag36h11", 2);
  scene.image_from_tag = straight(160, 120, 80);
  const Image image = picture_of(scene);
  LocateOptions options;
  options.search_radius = px(10);
  options.search_center = position_px(164.0, 116.0);
  expect_at(locate(image, tag_target("tag36h11", 80), nullptr, options), scene, 2, kNear);
  options.search_center = position_px(175.0, 120.0);
  EXPECT_EQ(locate(image, tag_target("tag36h11", 80), nullptr, options).status,
            DetectionStatus::NotFound);
}

TEST(TagDetector, SixteenBitsAreAsGood) {
  TagScene scene = scene_of("tagStandard41h12", 99);
  scene.full_scale = Image::kFullScale16;
  scene.image_from_tag = straight(160.7, 120.2, 90);
  expect_at(locate(picture_of(scene), tag_target("tagStandard41h12", 90)), scene, 99, kNear);
}

/// A crumb hides a corner with a part of the frame: the search sees that corner half a cell off,
/// the fit gets it from the rest of the pattern.
TEST(TagDetector, HiddenCornerIsFittedFromTheRest) {
  constexpr double kCrumbPx = 14;
  for (int i = 0; i < 4; ++i) {
    TagScene scene = scene_of("tag36h11", 7);
    Random random = Random(9).fork(static_cast<std::uint64_t>(i));
    scene.image_from_tag = random_pose(scene, 110, 0.4, random);
    Image image = tag_picture(scene, random);
    const Eigen::Vector2d hidden = scene.corners_px()[static_cast<std::size_t>(i)];
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        if ((Eigen::Vector2d(x, y) - hidden).norm() < kCrumbPx) image.at(x, y) = 60;
      }
    }
    SCOPED_TRACE(i);
    const Detection detection = locate(image, tag_target("tag36h11", 110));
    expect_at(detection, scene, 7, kNear);
    EXPECT_GT(detection.best->excluded, 0.005);
    EXPECT_LT(detection.best->visible, 1);
  }
}

/// One bit may be dirty if the family is far-spaced; the tag is still that one, and in its place.
TEST(TagDetector, OneWrongBitIsToleratedTwoAreNot) {
  const TagFamily family = *find_tag_family("tag36h11");
  TagScene scene = scene_of("tag36h11", 33);
  scene.image_from_tag = straight(160.4, 120.8);
  const auto flip = [&](std::size_t i) {
    const auto& bit = family.bits[i];
    TagCell& cell =
        scene.pattern.levels[static_cast<std::size_t>(bit.row * family.n_cells + bit.column)];
    cell = cell == TagCell::White ? TagCell::Black : TagCell::White;
  };
  flip(10);
  const Detection one = locate(picture_of(scene), tag_target());
  expect_at(one, scene, 33, kNear);
  EXPECT_LT(one.best->score, 0.99);
  EXPECT_GT(one.best->excluded, 0);
  flip(20);
  EXPECT_EQ(locate(picture_of(scene), tag_target()).status, DetectionStatus::NotFound);
}

TEST(TagDetector, CloseCodesTolerateNothing) {
  const TagFamily family = *find_tag_family("tag16h5");
  TagScene scene = scene_of("tag16h5", 12);
  scene.image_from_tag = straight(160.4, 120.8);
  for (const TagFamily::Bit& bit : family.bits) {
    TagScene dirty = scene;
    TagCell& cell =
        dirty.pattern.levels[static_cast<std::size_t>(bit.row * family.n_cells + bit.column)];
    cell = cell == TagCell::White ? TagCell::Black : TagCell::White;
    const Detection detection = locate(picture_of(dirty), tag_target("tag16h5"));
    EXPECT_NE(detection.status, DetectionStatus::Found) << *detection.best->tag_id;
  }
  expect_at(locate(picture_of(scene), tag_target("tag16h5")), scene, 12, kNear);
}

TEST(TagDetector, OddPicturesAreHarmless) {
  for (const auto& [width, height] : {std::pair{0, 0}, {1, 1}, {7, 300}, {300, 7}, {16, 16}}) {
    const Image image(width, height, 255, 128);
    EXPECT_EQ(locate(image, tag_target()).status, DetectionStatus::NotFound) << width << height;
    EXPECT_EQ(locate(image, tag_target("tag36h11", 1e-3)).status, DetectionStatus::NotFound);
    EXPECT_EQ(locate(image, tag_target("tag36h11", 1e9)).status, DetectionStatus::NotFound);
  }
}

TEST(TagDetector, UnknownFamilyFindsNothing) {
  TagScene scene = scene_of("tag36h11", 33);
  scene.image_from_tag = straight(160.4, 120.8);
  EXPECT_NE(locate(picture_of(scene), tag_target("tag99h99")).status, DetectionStatus::Found);
}

}  // namespace
}  // namespace panelcal::test
