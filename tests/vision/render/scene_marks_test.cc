// SPDX-License-Identifier: Apache-2.0
#include "vision/render/scene_marks.h"

#include <cmath>
#include <memory>

#include "vision/render/render.h"
#include "vision/tag/family.h"
#include <gtest/gtest.h>

#include "tests/vision/render/scene_support.h"

namespace panelcal::test {
namespace {

constexpr double kShare = 1e-6;

Camera upright_camera() {
  CameraMapping::Parameters parameters;
  parameters.scale_mm_per_px = kScale_mm;
  parameters.axis_px = {100, 90};
  Camera camera = scene_camera();
  camera.mapping = CameraMapping(parameters);
  return camera;
}

std::vector<double> picture_of(const Target& target, const Camera& camera, Angle turn = {}) {
  MarkLook look;
  look.turn = turn;
  look.level = 1;
  look.ground = 0;
  look.center = camera.mapping(position_px(100, 90));
  return render_levels(scene_of(mark_features(target, look, camera.mapping)), camera);
}

/// The target's level at a place given in pixels right of and below its centre.
double level_beside(const Target& target, int dx, int dy, Angle turn = {}) {
  const Camera camera = upright_camera();
  return level_at(picture_of(target, camera, turn), camera, 100 + dx, 90 + dy);
}

Target target_of(Shape shape, Length size) {
  Target target;
  target.shape = shape;
  target.size = size;
  return target;
}

TEST(SceneMarks, ASquareHasItsSidesAlongTheAxesAndADiamondItsTips) {
  const Target square = target_of(Shape::Square, mm(0.8));
  EXPECT_NEAR(level_beside(square, 33, 33), 1, kShare);
  EXPECT_NEAR(level_beside(square, 48, 0), 0, kShare);
  const Target diamond = target_of(Shape::Diamond, mm(0.8));
  EXPECT_NEAR(level_beside(diamond, 33, 33), 0, kShare);
  EXPECT_NEAR(level_beside(diamond, 48, 0), 1, kShare);
  EXPECT_NEAR(level_beside(diamond, 64, 0), 0, kShare);  // its tip is at 56.6
}

TEST(SceneMarks, ACrossHasBarsOfItsWidth) {
  Target cross = target_of(Shape::Cross, mm(1.2));
  cross.width = mm(0.2);
  EXPECT_NEAR(level_beside(cross, 52, 0), 1, kShare);
  EXPECT_NEAR(level_beside(cross, 0, -52), 1, kShare);
  EXPECT_NEAR(level_beside(cross, 68, 0), 0, kShare);
  EXPECT_NEAR(level_beside(cross, 30, 18), 0, kShare);
}

TEST(SceneMarks, ASlotRunsAlongItsAngle) {
  Target slot = target_of(Shape::Slot, mm(0.3));
  EXPECT_NEAR(level_beside(slot, 90, 0), 1, kShare);
  EXPECT_NEAR(level_beside(slot, 0, 24), 0, kShare);
  slot.angle = deg(90);
  EXPECT_NEAR(level_beside(slot, 0, 80), 1, kShare);
  EXPECT_NEAR(level_beside(slot, 24, 0), 0, kShare);
}

TEST(SceneMarks, ARingWithoutAHoleSizeHasOneOfHalfItsDiameter) {
  Target ring = target_of(Shape::Ring, mm(0.8));
  EXPECT_NEAR(level_beside(ring, 12, 0), 0, kShare);
  EXPECT_NEAR(level_beside(ring, 30, 0), 1, kShare);
  ring.inner_size = mm(0.1);
  EXPECT_NEAR(level_beside(ring, 14, 0), 1, kShare);
}

/// Turning is counter-clockwise where y is up, clockwise where y is down.
TEST(SceneMarks, TargetsInPixelsLieInThePicture) {
  Target dots = target_of(Shape::Dots, mm(0.2));
  dots.dots = {{0, 0}, {0.4, 0}, {0, 0.2}};
  EXPECT_NEAR(level_beside(dots, 40, 0), 1, kShare);
  EXPECT_NEAR(level_beside(dots, 0, -20), 1, kShare);
  EXPECT_NEAR(level_beside(dots, 0, -40, deg(90)), 1, kShare);
  Target in_px;
  in_px.shape = Shape::Dots;
  in_px.size_px = px(20);
  in_px.dots = {{0, 0}, {40, 0}, {0, 20}};
  EXPECT_NEAR(level_beside(in_px, 40, 0), 1, kShare);
  EXPECT_NEAR(level_beside(in_px, 0, 20), 1, kShare);
  EXPECT_NEAR(level_beside(in_px, 0, 40, deg(90)), 1, kShare);
}

/// Rotated about its optical axis, the camera still sees a target in px upright.
TEST(SceneMarks, TargetsInPixelsTurnWithTheCamera) {
  const Camera camera = scene_camera();  // 0.02 rad
  Target square;
  square.shape = Shape::Square;
  square.size_px = px(80);
  const auto levels = picture_of(square, camera);
  // Along an upright edge all pixels see the same share.
  for (int y = 70; y < 110; ++y) {
    EXPECT_NEAR(level_at(levels, camera, 60, y), level_at(levels, camera, 60, 90), kShare);
  }
}

TEST(SceneMarks, ATagStandsUpright) {
  Target tag = target_of(Shape::AprilTag, mm(0.96));
  tag.tag_id = 3;
  const auto pattern = tag_pattern(tag.tag_family, 3);
  ASSERT_TRUE(pattern);
  const Camera camera = upright_camera();
  const auto levels = picture_of(tag, camera);
  for (int row = 0; row < pattern->n_cells; ++row) {
    for (int column = 0; column < pattern->n_cells; ++column) {
      const auto middle = [&](int i) {
        const auto at = static_cast<std::size_t>(i);
        return 48 * (pattern->lines[at] + pattern->lines[at + 1]);
      };
      const int x = static_cast<int>(std::lround(100 + middle(column)));
      const int y = static_cast<int>(std::lround(90 + middle(row)));
      if (pattern->at(column, row) == TagCell::Any) continue;
      const double expected = pattern->at(column, row) == TagCell::White ? 1 : 0;
      EXPECT_NEAR(level_at(levels, camera, x, y), expected, 1e-4) << column << " " << row;
    }
  }
}

/// A mark darker than its ground: white cells are the mark, whatever its brightness.
TEST(SceneMarks, ADarkTagIsTheNegative) {
  Target tag = target_of(Shape::AprilTag, mm(0.96));
  tag.tag_id = 3;
  const Camera camera = upright_camera();
  const auto bright = picture_of(tag, camera);
  MarkLook look;
  look.level = 0;
  look.ground = 1;
  look.center = camera.mapping(position_px(100, 90));
  const auto dark = render_levels(scene_of(mark_features(tag, look, camera.mapping)), camera);
  for (int y = 50; y < 130; ++y) {  // all of it within the tag's corners
    for (int x = 60; x < 140; ++x) {
      EXPECT_NEAR(level_at(dark, camera, x, y), 1 - level_at(bright, camera, x, y), kShare);
    }
  }
}

TEST(SceneMarks, AnUnknownTagIsNothing) {
  Target tag = target_of(Shape::AprilTag, mm(1));
  tag.tag_id = 1'000'000;
  EXPECT_TRUE(mark_features(tag, {}, upright_camera().mapping).empty());
}

/// A picture of a disc, lying on the board, looks like the disc.
class PictureMarks : public testing::Test {
 protected:
  static constexpr double kBlur_px = 1.5;

  Target target() const {
    Camera camera = upright_camera();
    camera.width = 101;
    camera.height = 91;
    camera.blur_px = kBlur_px;
    camera.full_scale = 65535;
    Feature disc;
    disc.center = camera.mapping(position_px(52, 44));
    disc.size = mm(0.5);
    disc.level = 0.8;
    Scene scene = scene_of({disc});
    scene.background = 0.2;
    Random random(1);
    auto picture = std::make_shared<TemplatePicture>();
    picture->image = render(scene, camera, random);
    picture->reference_px = {52, 44};
    Target target;
    target.shape = Shape::Template;
    target.size = mm(1.01);
    target.picture = picture;
    return target;
  }

  /// Farthest from a disc rendered at that place, inside of the picture.
  double worst(double x_px, double y_px, Angle turn) const {
    Camera camera = upright_camera();
    camera.blur_px = kBlur_px;
    MarkLook look;
    look.turn = turn;
    look.center = camera.mapping(position_px(x_px, y_px));
    Scene scene = scene_of(mark_features(target(), look, camera.mapping));
    scene.background = 0.2;
    const auto picture = render_levels(scene, camera);
    Feature disc;
    disc.center = look.center;
    disc.size = mm(0.5);
    disc.level = 0.8;
    scene.features = {disc};
    const auto truth = render_levels(scene, camera);
    double worst = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      worst = std::max(worst, std::abs(truth[i] - picture[i]));
    }
    return worst;
  }
};

TEST_F(PictureMarks, AtWholePixelsAreThePicture) {
  EXPECT_LT(worst(103, 91, {}), 1.0 / 65535);
}

TEST_F(PictureMarks, BetweenPixelsAreItsSpline) {
  constexpr double kSpline = 1e-3;  // error of cubic splines at a blur of 1.5 px
  EXPECT_LT(worst(103.4, 90.7, {}), kSpline);
  EXPECT_LT(worst(103.4, 90.7, deg(33)), kSpline);
}

TEST(SceneMarks, ReachHoldsTheMark) {
  const CameraMapping mapping = upright_camera().mapping;
  const Target square = target_of(Shape::Square, mm(1));
  EXPECT_NEAR(reach_of(mark_features(square, {}, mapping), {}).in_mm(), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(
      reach_of(mark_features(target_of(Shape::Disc, mm(1)), {}, mapping), {}).in_mm(), 0.5, 1e-12);
}

}  // namespace
}  // namespace panelcal::test
