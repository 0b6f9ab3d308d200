// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/model.h"

#include <cmath>
#include <limits>

#include "calib/base/statistics/random.h"
#include <Eigen/Geometry>
#include <gmock/gmock.h>

#include "tests/calib/camera/simulated_camera.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::IsNearMatrix;

constexpr int kTrials = 50;
/// Rounding of millimetres and pixels, several times over.
constexpr double kRounding = 1e-11;

CameraModel::Parameters random_camera(Random& random) {
  CameraModel::Parameters p = test::bent_camera();
  p.scale_mm_per_px *= random.uniform(0.5, 2);
  p.rotation_rad = random.uniform(-3, 3);
  p.tilt = {random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)};
  p.k1_per_px2 *= random.uniform(-1, 1);
  p.k2_per_px4 *= random.uniform(-1, 1);
  p.p1_per_px *= random.uniform(-1, 1);
  p.p2_per_px *= random.uniform(-1, 1);
  return p;
}

Position<frame::Image> random_pixel(Random& random) {
  return position_px(random.uniform(0, 640), random.uniform(0, 480));
}

/// Straight lines in space: the panel is a plane turned about a line through the axis' point.
Eigen::Vector2d by_rays(const CameraModel::Parameters& p, const Position<frame::Image>& u) {
  const Eigen::Vector2d d_px = u.in_px() - p.axis_px;
  const Eigen::Vector2d flat_px =
      Eigen::Rotation2Dd(p.rotation_rad) * Eigen::Vector2d(d_px.x(), -d_px.y());
  const double distance_mm = p.scale_mm_per_px * p.focal_px;
  // x, y as on the machine, z away from the camera; the far side lies where the tilt points.
  const double angle_rad = std::atan(p.tilt.norm());
  const Eigen::Vector2d toward = p.tilt.normalized();
  const Eigen::AngleAxisd turn(-angle_rad, Eigen::Vector3d(-toward.y(), toward.x(), 0));
  const Eigen::Vector3d ex = turn * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d ey = turn * Eigen::Vector3d::UnitY();
  const Eigen::Vector3d normal = turn * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d center(0, 0, distance_mm);
  const Eigen::Vector3d ray(flat_px.x(), flat_px.y(), p.focal_px);
  const Eigen::Vector3d hit = ray * (normal.dot(center) / normal.dot(ray)) - center;
  return {ex.dot(hit), ey.dot(hit)};
}

TEST(CameraModel, ProjectsOntoATiltedPanel) {
  Random random(1);
  for (int trial = 0; trial < kTrials; ++trial) {
    CameraModel::Parameters p = random_camera(random);
    p.k1_per_px2 = p.k2_per_px4 = p.p1_per_px = p.p2_per_px = 0;
    const Position<frame::Image> u = random_pixel(random);
    EXPECT_THAT(CameraModel(p)(u).in_mm(), IsNearMatrix(by_rays(p, u), kRounding));
  }
}

TEST(CameraModel, IsTheSimpleMappingWithoutTiltAndFurtherLensTerms) {
  Random random(2);
  const CameraMapping::Parameters simple{
      .scale_mm_per_px = 0.0098, .rotation_rad = 0.03, .axis_px = {318, 243}, .k1_per_px2 = 4e-8};
  const CameraModel model(simple);
  const CameraMapping mapping(simple);
  for (int trial = 0; trial < kTrials; ++trial) {
    const Position<frame::Image> u = random_pixel(random);
    EXPECT_THAT(model(u).in_mm(), IsNearMatrix(mapping(u).in_mm(), kRounding));
    const CameraJacobian expected = mapping.by_parameters(u);
    const CameraModelJacobian actual = model.by_parameters(u);
    EXPECT_THAT(actual.leftCols<2>(), IsNearMatrix(expected.leftCols<2>(), 1e-8));
    EXPECT_THAT(actual.col(4), IsNearMatrix(expected.col(4), 1e-6));
  }
  const auto back = model.as_mapping();
  ASSERT_TRUE(back);
  EXPECT_EQ(back->scale_mm_per_px, simple.scale_mm_per_px);
  EXPECT_EQ(back->k1_per_px2, simple.k1_per_px2);
  EXPECT_EQ(back->axis_px, simple.axis_px);
  CameraModel::Parameters tilted = model.parameters();
  tilted.tilt.x() = 1e-6;
  EXPECT_FALSE(CameraModel(tilted).as_mapping());
}

TEST(CameraModel, ItsDerivativesAreThoseOfDifferences) {
  Random random(3);
  for (int trial = 0; trial < kTrials; ++trial) {
    const CameraModel::Parameters p = random_camera(random);
    const Position<frame::Image> u = random_pixel(random);
    const double h_px = 1e-3;
    for (int axis = 0; axis < 2; ++axis) {
      const auto step = displacement_px<frame::Image>(h_px * Eigen::Vector2d::Unit(axis));
      const CameraModel model(p);
      const Eigen::Vector2d difference =
          (model(u + step).in_mm() - model(u - step).in_mm()) / (2 * h_px);
      EXPECT_THAT(model.jacobian(u).col(axis), IsNearMatrix(difference, 1e-10));
    }
    // One step for each parameter that moves the picture's corner by about a pixel.
    const double steps[] = {1e-5, 1e-3, 1e-3, 1e-3, 1e-8, 1e-13, 1e-6, 1e-6};
    for (int i = 0; i < kCameraParameters; ++i) {
      const auto moved = [&](double by) {
        CameraModel::Parameters q = p;
        double* values[] = {&q.scale_mm_per_px,
                            &q.rotation_rad,
                            &q.tilt[0],
                            &q.tilt[1],
                            &q.k1_per_px2,
                            &q.k2_per_px4,
                            &q.p1_per_px,
                            &q.p2_per_px};
        *values[i] += by;
        return CameraModel(q)(u).in_mm();
      };
      const Eigen::Vector2d difference = moved(steps[i]) - moved(-steps[i]);
      const Eigen::Vector2d predicted = 2 * steps[i] * CameraModel(p).by_parameters(u).col(i);
      // Third order of a step of a pixel in 400.
      EXPECT_THAT(predicted, IsNearMatrix(difference, 1e-5 * (1e-3 + difference.norm())))
          << name(static_cast<CameraParameter>(i));
    }
  }
}

TEST(CameraModel, FindsThePixelOfAPlace) {
  Random random(4);
  for (int trial = 0; trial < kTrials; ++trial) {
    const CameraModel model(random_camera(random));
    const Position<frame::Image> u = random_pixel(random);
    const auto found = model.image_of(model(u));
    ASSERT_TRUE(found);
    EXPECT_THAT(found->in_px(), IsNearMatrix(u.in_px(), 1e-8));
  }
}

TEST(CameraModel, SeesNeitherBeyondTheHorizonNorBeyondTheFold) {
  CameraModel::Parameters tilted = test::straight_camera();
  tilted.tilt = {1, 0};
  tilted.focal_px = 1000;
  EXPECT_TRUE(CameraModel(tilted).sees(position_px(1300, 240)));
  EXPECT_FALSE(CameraModel(tilted).sees(position_px(1400, 240)));

  CameraModel::Parameters folding = test::straight_camera();
  folding.k1_per_px2 = -1 / (3 * 300.0 * 300.0);
  EXPECT_TRUE(CameraModel(folding).sees(position_px(320 + 299, 240)));
  EXPECT_FALSE(CameraModel(folding).sees(position_px(320 + 301, 240)));
  EXPECT_FALSE(CameraModel(folding).image_of(position_mm<frame::Optical>(2.1, 0)));
  EXPECT_TRUE(CameraModel(folding).image_of(position_mm<frame::Optical>(1.9, 0)));
}

TEST(CameraModel, AnswersNothingToNoNumber) {
  const CameraModel model(test::bent_camera());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(model.image_of(position_mm<frame::Optical>(nan, 0)));
  EXPECT_FALSE(model.sees(position_px(nan, 0)));
  CameraModel::Parameters p = test::bent_camera();
  p.tilt.x() = nan;
  EXPECT_FALSE(CameraModel::is_valid(p));
  p = test::bent_camera();
  p.focal_px = 0;
  EXPECT_FALSE(CameraModel::is_valid(p));
}

}  // namespace
}  // namespace panelcal
