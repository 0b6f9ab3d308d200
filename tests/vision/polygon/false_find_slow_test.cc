// SPDX-License-Identifier: Apache-2.0
// Pictures without the target: nothing may be found in them.
#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/vision/polygon/trial.h"

namespace panelcal::test {
namespace {

constexpr double kScaleMm = 0.01;  // per px
constexpr int kSide = 320;
constexpr int kPictures = 300;

Camera camera_of(Random& random) {
  const CameraMapping::Parameters parameters{
      .scale_mm_per_px = kScaleMm,
      .rotation_rad = 0,
      .axis_px = Eigen::Vector2d::Constant(0.5 * (kSide - 1)),
      .k1_per_px2 = 0};
  return {.mapping = CameraMapping(parameters),
          .width = kSide,
          .height = kSide,
          .blur_px = random.uniform(0.7, 2.5),
          .noise = random.uniform(1, 10)};
}

/// Something that is not the shape of that size: another shape, a wrong size, or turned too far.
Feature stranger(Shape shape, double size_mm, double level, Random& random) {
  const double kind = random.uniform();
  const double turn = random.uniform(-0.08, 0.08);
  Feature feature;
  if (kind < 0.25) {  // a disc as wide, or of the same area
    feature.size = mm(size_mm * random.uniform(0.95, 1.2));
  } else if (kind < 0.4) {
    feature.shape = Feature::Shape::Ring;
    feature.size = mm(size_mm * random.uniform(0.9, 1.3));
    feature.inner_size = 0.5 * feature.size;
  } else if (kind < 0.55) {  // an oblong pad
    feature.shape = Feature::Shape::Rectangle;
    feature.size = mm(size_mm * random.uniform(0.9, 1.1));
    feature.inner_size = feature.size * random.uniform(0.3, 0.8);
    feature.angle = rad(turn);
  } else if (kind < 0.75) {  // the right shape of a wrong size
    const double wrong =
        random.uniform() < 0.5 ? random.uniform(0.6, 0.94) : random.uniform(1.06, 1.5);
    feature = cell_feature(shape, size_mm * wrong, 0.3 * size_mm * wrong, turn, level);
  } else {  // one of the other shapes
    const Shape others[3] = {Shape::Square, Shape::Diamond, Shape::Cross};
    Shape other = others[static_cast<int>(3 * random.uniform())];
    if (other == shape) other = shape == Shape::Cross ? Shape::Square : Shape::Cross;
    feature = cell_feature(other, size_mm * random.uniform(0.8, 1.2), 0.3 * size_mm, turn, level);
  }
  feature.level = level;
  return feature;
}

Scene scene_without(
    Shape shape, bool is_dark, double size_mm, const Camera& camera, Random& random) {
  Scene scene;
  scene.background = is_dark ? 0.7 : 0.25;
  const double level = scene.background + (is_dark ? -1 : 1) * random.uniform(0.1, 0.5);
  scene.light_gradient = {random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)};
  if (random.uniform() < 0.5) {
    scene.weave.amplitude = random.uniform(0.01, 0.06);
    scene.weave.panel_from_optical = Transform<frame::Nominal, frame::Optical>(
        Eigen::Matrix2d::Identity(), {random.uniform(0, 300), random.uniform(0, 300)});
  }
  const int n = static_cast<int>(random.uniform(0, 5));
  for (int i = 0; i < n; ++i) {
    Feature feature = stranger(shape, size_mm, level, random);
    feature.center = camera.mapping(position_px<frame::Image>(
        {random.uniform(-20, kSide + 20), random.uniform(-20, kSide + 20)}));
    scene.features.push_back(feature);
  }
  return scene;
}

/// Pictures of `n` with something found, and what.
std::string found_in(Shape shape, Polarity polarity, int n, int& n_found) {
  std::string all;
  n_found = 0;
  for (int i = 0; i < n; ++i) {
    Random random = Random(77).fork(static_cast<std::uint64_t>(i));
    const double size_px = random.uniform(20, 90);
    const Camera camera = camera_of(random);
    const Scene scene =
        scene_without(shape, polarity == Polarity::Dark, size_px * kScaleMm, camera, random);
    const Image image = render(scene, camera, random);
    Target target;
    target.shape = shape;
    target.polarity = polarity;
    target.size_px = px(size_px);
    if (shape == Shape::Cross) target.width_px = px(0.3 * size_px);
    const Detection detection = locate(image, target);
    if (detection.status != DetectionStatus::Found &&
        detection.status != DetectionStatus::Ambiguous) {
      continue;
    }
    ++n_found;
    const TargetFit& fit = *detection.best;
    all += fmt::format(
        "draw {}: size {:.1f} at {:.1f} {:.1f}, seen {:.1f}, score {:.2f}, visible {:.2f}\n",
        i,
        size_px,
        fit.center.position.in_px().x(),
        fit.center.position.in_px().y(),
        fit.size.in_px(),
        fit.score,
        fit.visible);
  }
  return all;
}

class CellFalse : public ::testing::TestWithParam<Shape> {};

TEST_P(CellFalse, NothingIsFoundWhereNothingIs) {
  int n_found = 0;
  const std::string what = found_in(GetParam(), Polarity::Bright, kPictures, n_found);
  EXPECT_EQ(n_found, 0) << what;
}

TEST_P(CellFalse, NothingDarkIsFoundWhereNothingIs) {
  int n_found = 0;
  const std::string what = found_in(GetParam(), Polarity::Dark, kPictures / 2, n_found);
  EXPECT_EQ(n_found, 0) << what;
}

INSTANTIATE_TEST_SUITE_P(Shapes,
                         CellFalse,
                         ::testing::Values(Shape::Square, Shape::Diamond, Shape::Cross),
                         [](const auto& shape) { return std::string(name(shape.param)); });

}  // namespace
}  // namespace panelcal::test
