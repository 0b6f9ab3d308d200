// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/exchange/lens_camera.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

Lens usual_lens() {
  Lens lens;
  lens.width_px = 1200;
  lens.height_px = 900;
  lens.focal_px = {3000, 3000};
  lens.center_px = {610, 440};
  lens.k1 = -0.08;
  lens.k2 = 0.03;
  lens.p1 = 0.0007;
  lens.p2 = -0.0004;
  return lens;
}

/// The pixel of a ray, written out from the header's equations.
Eigen::Vector2d pixel_of(const Lens& lens, double x, double y) {
  const double rr = x * x + y * y;
  const double radial = 1 + lens.k1 * rr + lens.k2 * rr * rr + lens.k3 * rr * rr * rr;
  const double bent_x = x * radial + 2 * lens.p1 * x * y + lens.p2 * (rr + 2 * x * x);
  const double bent_y = y * radial + lens.p1 * (rr + 2 * y * y) + 2 * lens.p2 * x * y;
  return {lens.focal_px.x() * bent_x + lens.center_px.x(),
          lens.focal_px.y() * bent_y + lens.center_px.y()};
}

TEST(LensCamera, PutsRaysWhereThePanelIs) {
  const Lens lens = usual_lens();
  const double scale = 0.02, rotation = 0.3;
  const auto found = camera_of_lens(lens, {.scale_mm_per_px = scale, .rotation_rad = rotation});
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_LT(found->error_px, 0.01);
  const CameraModel model = found->calibration.model();
  for (const double x : {-0.19, -0.05, 0.0, 0.11, 0.18}) {
    for (const double y : {-0.13, 0.0, 0.07, 0.14}) {
      // The panel lies at distance scale f; y points down in the picture.
      const double east = scale * 3000 * x, north = -scale * 3000 * y;
      const Eigen::Vector2d wanted(std::cos(rotation) * east - std::sin(rotation) * north,
                                   std::sin(rotation) * east + std::cos(rotation) * north);
      const Eigen::Vector2d place_mm =
          model(position_px<frame::Image>(pixel_of(lens, x, y))).in_mm();
      EXPECT_LT((place_mm - wanted).norm(), scale * found->error_px * 1.05) << x << ' ' << y;
    }
  }
}

TEST(LensCamera, StatesTheSigmaOfTheFarthestCorner) {
  const auto found = camera_of_lens(usual_lens(), {.scale_mm_per_px = 0.02, .corner_sigma = um(8)});
  ASSERT_TRUE(found) << found.error().text();
  // The corner at (-0.5, 899.5), by scale and rotation alone.
  const double r_px = std::hypot(610.5, 459.5);
  const auto& cov = found->calibration.full->covariance;
  EXPECT_NEAR(std::sqrt(cov(0, 0) + 0.02 * 0.02 * cov(1, 1)) * r_px, 0.008, 1e-12);
}

TEST(LensCamera, IsExactWithoutALens) {
  Lens lens = usual_lens();
  lens.k1 = lens.k2 = lens.p1 = lens.p2 = 0;
  const auto found = camera_of_lens(lens, {});
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->error_px, 0);
  EXPECT_EQ(found->calibration.full->form, CameraForm::Flat);
  const auto text = camera_calibration_text(found->calibration);
  EXPECT_TRUE(parse_camera_calibration(text, "again")) << text;
}

TEST(LensCamera, LeadsBackToTheLens) {
  const Lens lens = usual_lens();
  const auto camera = camera_of_lens(lens, {});
  ASSERT_TRUE(camera) << camera.error().text();
  const auto back = lens_of_camera(camera->calibration, std::nullopt);
  ASSERT_TRUE(back) << back.error().text();
  for (const double x : {-0.19, 0.0, 0.18}) {
    for (const double y : {-0.13, 0.05, 0.14}) {
      EXPECT_LT((pixel_of(back->lens, x, y) - pixel_of(lens, x, y)).norm(),
                camera->error_px + back->error_px + 1e-9);
    }
  }
}

TEST(LensCamera, RefusesWhatItsModelCannotFollow) {
  Lens lens = usual_lens();
  lens.focal_px.y() = 3001;
  EXPECT_THAT(camera_of_lens(lens, {}), FailsWith(Code::CalibrationInvalid, "not square"));
  lens = usual_lens();
  lens.focal_px = {900, 900};
  lens.k1 = -0.12;
  EXPECT_THAT(camera_of_lens(lens, {}), FailsWith(Code::CalibrationInvalid, "misses"));
  lens.k1 = -3;
  EXPECT_THAT(camera_of_lens(lens, {}), FailsWith(Code::CalibrationInvalid, "folds over"));
  EXPECT_THAT(camera_of_lens(usual_lens(), {.scale_mm_per_px = 0}),
              FailsWith(Code::CalibrationInvalid));
  EXPECT_THAT(camera_of_lens(usual_lens(), {.max_error_px = 1e-9}),
              FailsWith(Code::CalibrationInvalid, "misses"));
}

TEST(LensCamera, RefusesToExportATiltOrATelecentricLens) {
  CameraCalibration camera = camera_of_lens(usual_lens(), {})->calibration;
  camera.full->parameters.tilt = {0.01, 0};
  EXPECT_THAT(lens_of_camera(camera, std::nullopt), FailsWith(Code::CalibrationInvalid, "a tilt"));
  camera.full->parameters.tilt.setZero();
  camera.full->parameters.focal_px = std::numeric_limits<double>::infinity();
  EXPECT_THAT(lens_of_camera(camera, std::nullopt),
              FailsWith(Code::CalibrationInvalid, "--focal-px"));
  EXPECT_TRUE(lens_of_camera(camera, 2000.0));
}

}  // namespace
}  // namespace panelcal
