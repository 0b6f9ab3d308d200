// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>

#include "vision/render/outline_circle.h"
#include "vision/render/render.h"
#include <gtest/gtest.h>

#include "tests/vision/render/scene_support.h"

namespace panelcal::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kArea = 1e-6;  // relative
constexpr double kCenter_px = 1e-4;
/// The tables of PixelResponse are good to 1e-8, a pixel sees a few hundred nodes of them.
constexpr double kShare = 1e-7;

struct KnownShape {
  std::string name;
  Feature feature;
  double area_px = 0;
};

std::shared_ptr<const CellGrid> cross_cells(double level) {
  CellGrid grid;
  grid.x = {mm(-0.4), mm(-0.1), mm(0.1), mm(0.4)};
  grid.y = grid.x;
  grid.levels = {{}, level, {}, level, level, level, {}, level, {}};
  return std::make_shared<const CellGrid>(std::move(grid));
}

std::vector<KnownShape> known_shapes() {
  Feature disc;
  disc.size = mm(0.8);
  disc.level = 0.7;
  Feature ring = disc;
  ring.shape = Feature::Shape::Ring;
  ring.inner_size = mm(0.4);
  Feature square = disc;
  square.shape = Feature::Shape::Rectangle;
  square.inner_size = square.size;
  square.angle = deg(17);
  Feature diamond = square;
  diamond.angle = deg(45);
  Feature slot = square;
  slot.shape = Feature::Shape::Stadium;
  slot.inner_size = mm(0.3);
  Feature cross = square;
  cross.shape = Feature::Shape::Cells;
  cross.cells = cross_cells(0.7);
  return {{"disc", disc, kPi * 1600},
          {"ring", ring, kPi * 1200},
          {"square", square, 6400},
          {"diamond", diamond, 6400},
          {"slot", slot, 50 * 30 + kPi * 225},
          {"cross", cross, 80 * 20 * 2 - 400}};
}

class RenderShapes : public testing::TestWithParam<KnownShape> {
 protected:
  Scene scene_at(const Camera& camera, const Eigen::Vector2d& u_px) const {
    Feature feature = GetParam().feature;
    feature.center = camera.mapping(position_px<frame::Image>(u_px));
    return scene_of({feature});
  }
};

TEST_P(RenderShapes, HaveTheirAreaAndCentre) {
  for (const double blur_px : {0.6, 1.0, 2.5}) {
    const Camera camera = scene_camera(blur_px);
    const Eigen::Vector2d center_px(99.37, 88.81);
    const auto levels = render_levels(scene_at(camera, center_px), camera);
    const Moments moments = moments_of(levels, camera.width);
    EXPECT_NEAR(moments.sum / (0.7 * GetParam().area_px), 1, kArea) << blur_px;
    EXPECT_NEAR(moments.center_px.x(), center_px.x(), kCenter_px) << blur_px;
    EXPECT_NEAR(moments.center_px.y(), center_px.y(), kCenter_px) << blur_px;
  }
}

TEST_P(RenderShapes, ShrinkAcrossTheAxisOfATilt) {
  Camera camera = scene_camera();
  camera.tilt = deg(8);
  camera.tilt_axis = deg(30);
  const auto levels = render_levels(scene_at(camera, camera.mapping.parameters().axis_px), camera);
  const Moments moments = moments_of(levels, camera.width);
  const double area_px = GetParam().area_px * std::cos(deg(8).in_rad());
  EXPECT_NEAR(moments.sum / (0.7 * area_px), 1, kArea);
  EXPECT_NEAR(moments.center_px.x(), 103, kCenter_px);
  EXPECT_NEAR(moments.center_px.y(), 88, kCenter_px);
}

INSTANTIATE_TEST_SUITE_P(All,
                         RenderShapes,
                         testing::ValuesIn(known_shapes()),
                         [](const auto& param) { return param.param.name; });

/// Integral of a pixel's sensitivity from minus infinity: box * Gauss, in closed form.
double response_integral(double x, double blur_px) {
  const auto antiderivative = [](double t) {
    return t * 0.5 * std::erfc(-t / std::numbers::sqrt2) +
           std::exp(-0.5 * t * t) / std::sqrt(2 * kPi);
  };
  return blur_px * (antiderivative((x + 0.5) / blur_px) - antiderivative((x - 0.5) / blur_px));
}

/// Along the pixels' axes a rectangle's share is a product.
TEST(Render, AnUprightRectangleIsTheProductOfTwoEdges) {
  CameraMapping::Parameters parameters;
  parameters.scale_mm_per_px = kScale_mm;
  Camera camera = scene_camera(0.8);
  camera.mapping = CameraMapping(parameters);
  Feature bar;
  bar.shape = Feature::Shape::Rectangle;
  bar.center = camera.mapping(position_px(60.3, 50.9));
  bar.size = mm(0.43);
  bar.inner_size = mm(0.171);
  bar.level = 1;
  const auto levels = render_levels(scene_of({bar}), camera);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double across =
          response_integral(60.3 + 21.5 - x, 0.8) - response_integral(60.3 - 21.5 - x, 0.8);
      const double along =
          response_integral(50.9 + 8.55 - y, 0.8) - response_integral(50.9 - 8.55 - y, 0.8);
      ASSERT_NEAR(level_at(levels, camera, x, y), across * along, kShare) << x << " " << y;
    }
  }
}

TEST(Render, ALensBendsOutlinesAsItBendsPlaces) {
  CameraMapping::Parameters parameters;
  parameters.scale_mm_per_px = kScale_mm;
  parameters.axis_px = {30, 20};
  parameters.k1_per_px2 = -2e-6;
  Camera camera = scene_camera();
  camera.mapping = CameraMapping(parameters);
  Feature disc;
  disc.center = camera.mapping(position_px(120, 100));
  disc.size = mm(0.7);
  disc.level = 1;
  // The outline as a polygon, drawn place by place: its area and centre of gravity.
  double area = 0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  constexpr int kCorners = 200'000;
  Eigen::Vector2d last;
  for (int i = 0; i <= kCorners; ++i) {
    const double angle = 2 * kPi * i / kCorners;
    const auto at = disc.center +
                    displacement_mm<frame::Optical>(0.35 * std::cos(angle), 0.35 * std::sin(angle));
    const Eigen::Vector2d u_px = camera.mapping.image_of(at)->in_px();
    if (i > 0) {
      const double cross = last.x() * u_px.y() - last.y() * u_px.x();
      area += 0.5 * cross;
      moment += cross / 6 * (last + u_px);
    }
    last = u_px;
  }
  const Moments moments = moments_of(render_levels(scene_of({disc}), camera), camera.width);
  EXPECT_NEAR(moments.sum / std::abs(area), 1, kArea);
  EXPECT_NEAR((moments.center_px - moment / area).norm(), 0, kCenter_px);
  EXPECT_GT((moments.center_px - Eigen::Vector2d(120, 100)).norm(), 0.01);  // it does bend
}

TEST(Render, ARingsHoleMayBeOffCentre) {
  const Camera camera = scene_camera();
  Feature ring;
  ring.shape = Feature::Shape::Ring;
  ring.center = camera.mapping(position_px(100, 90));
  ring.size = mm(0.8);
  ring.inner_size = mm(0.4);
  ring.level = 1;
  const auto hole_center = camera.mapping(position_px(104, 87));
  ring.hole_offset = hole_center - ring.center;
  const Moments moments = moments_of(render_levels(scene_of({ring}), camera), camera.width);
  // A quarter of the area is missing at (4, -3) from the centre.
  EXPECT_NEAR(moments.center_px.x(), 100 - 4.0 / 3, kCenter_px);
  EXPECT_NEAR(moments.center_px.y(), 90 + 3.0 / 3, kCenter_px);
}

TEST(Render, CellsHaveNoSeams) {
  const Camera camera = scene_camera();
  Feature plate;
  plate.shape = Feature::Shape::Rectangle;
  plate.center = camera.mapping(position_px(95.2, 90.7));
  plate.size = mm(0.9);
  plate.inner_size = mm(0.6);
  plate.angle = deg(23);
  plate.level = 0.6;
  Feature cells = plate;
  cells.shape = Feature::Shape::Cells;
  cells.cells =
      std::make_shared<const CellGrid>(CellGrid{{mm(-0.45), mm(-0.31), mm(0.02), mm(0.45)},
                                                {mm(-0.3), mm(0.11), mm(0.3)},
                                                {0.6, 0.6, 0.6, 0.6, 0.6, 0.6}});
  Scene scene = scene_of({plate});
  scene.background = 0.9;
  const auto whole = render_levels(scene, camera);
  scene.features = {cells};
  const auto parts = render_levels(scene, camera);
  for (std::size_t i = 0; i < whole.size(); ++i) ASSERT_NEAR(whole[i], parts[i], kShare);
}

TEST(Render, EmptyCellsShowWhatIsBelow) {
  const Camera camera = scene_camera();
  Feature cross;
  cross.shape = Feature::Shape::Cells;
  cross.center = camera.mapping(position_px(100, 90));
  cross.cells = cross_cells(0.0);  // black on grey
  Scene scene = scene_of({cross});
  scene.background = 0.5;
  const auto levels = render_levels(scene, camera);
  EXPECT_NEAR(level_at(levels, camera, 100, 90), 0, kShare);
  EXPECT_NEAR(level_at(levels, camera, 125, 65), 0.5, kShare);
  EXPECT_NEAR(level_at(levels, camera, 100, 60), 0, kShare);
}

TEST(Render, CellsRunUpwards) {
  const Camera camera = scene_camera();
  Feature cells;
  cells.shape = Feature::Shape::Cells;
  cells.center = camera.mapping(position_px(100, 90));
  cells.cells = std::make_shared<const CellGrid>(
      CellGrid{{mm(-0.4), mm(0), mm(0.4)}, {mm(-0.4), mm(0), mm(0.4)}, {0.1, 0.2, 0.3, 0.4}});
  const auto levels = render_levels(scene_of({cells}), camera);
  EXPECT_NEAR(level_at(levels, camera, 80, 110), 0.1, kShare);
  EXPECT_NEAR(level_at(levels, camera, 120, 110), 0.2, kShare);
  EXPECT_NEAR(level_at(levels, camera, 80, 70), 0.3, kShare);
  EXPECT_NEAR(level_at(levels, camera, 120, 70), 0.4, kShare);
}

TEST(RoughCircle, HasTheRmsAskedForAndNoShift) {
  const Roughness roughness{um(12), 2, 24, 7};
  const internal::RoughCircle circle(0.4, roughness);
  constexpr int kSamples = 4096;
  double squares = 0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  for (int i = 0; i < kSamples; ++i) {
    const double angle = 2 * kPi * i / kSamples;
    const double d = circle.radius_mm(angle) - 0.4;
    squares += d * d / kSamples;
    shift += d / kSamples * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    EXPECT_LE(circle.radius_mm(angle), circle.reach_mm());
  }
  EXPECT_NEAR(std::sqrt(squares), 0.012, 1e-9);
  EXPECT_NEAR(shift.norm(), 0, 1e-12);
}

TEST(RoughCircle, DerivativeAgreesWithDifferences) {
  const internal::RoughCircle circle(0.4, {um(12), 2, 24, 7});
  for (const double angle : {0.1, 1.7, 4.4}) {
    const double slope = (circle.radius_mm(angle + 1e-6) - circle.radius_mm(angle - 1e-6)) / 2e-6;
    EXPECT_NEAR(circle.evaluate(angle).y(), slope, 1e-7);
  }
}

TEST(Render, BurrsChangeTheAreaByTheirSquares) {
  const Camera camera = scene_camera();
  Feature hole;
  hole.center = camera.mapping(position_px(100.2, 90.4));
  hole.size = mm(0.8);
  hole.level = 1;
  hole.roughness = {um(12), 2, 24, 7};
  const Moments moments = moments_of(render_levels(scene_of({hole}), camera), camera.width);
  EXPECT_NEAR(moments.sum / (kPi * (1600 + 1.2 * 1.2)), 1, kArea);
}

TEST(Render, EvenWildRimsStayOutlines) {
  const internal::RoughCircle circle(0.1, {mm(10), 2, 7, 3});
  for (int i = 0; i < 1000; ++i) EXPECT_GT(circle.radius_mm(2 * kPi * i / 1000), 0.03);
}

}  // namespace
}  // namespace panelcal::test
