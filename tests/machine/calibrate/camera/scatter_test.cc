// SPDX-License-Identifier: Apache-2.0
// What few views say of their own scatter: sigmas, outliers, the form. No picture is drawn here.
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "machine/calibrate/camera/outliers.h"
#include "machine/calibrate/camera/run.h"
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/calib/camera/simulated_camera.h"

namespace panelcal {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kStated_px = 0.01;
/// Of a stage that comes back less well than [uncertainty] states.
constexpr double kNoise_px = 0.05;

constexpr int kWidth_px = 640;
constexpr int kHeight_px = 480;
const Eigen::Vector2d kAxis_px(0.5 * (kWidth_px - 1), 0.5 * (kHeight_px - 1));

/// One mark in per_side^2 views of a flat telecentric camera, 60 px from the border and farther in,
/// with noise.
MarkSights sights_of(int per_side, double noise_px, std::uint64_t seed) {
  CameraModel::Parameters p = test::straight_camera();
  p.axis_px = kAxis_px;
  p.focal_px = std::numeric_limits<double>::infinity();
  const CameraModel camera(p);
  MarkSights sights;
  sights.width_px = kWidth_px;
  sights.height_px = kHeight_px;
  CameraData& data = sights.data;
  data.dots = {{position_mm<frame::Plate>(0, 0), false, Length()}};
  const PlatePose pose{0, {100.03, 79.96}};
  constexpr double kMargin_px = 60;
  for (int row = 0; row < per_side; ++row) {
    for (int column = 0; column < per_side; ++column) {
      const Eigen::Vector2d part(column / (per_side - 1.0), row / (per_side - 1.0));
      const Eigen::Vector2d u_px =
          part.cwiseProduct(2 * (kAxis_px - Eigen::Vector2d::Constant(kMargin_px))) +
          Eigen::Vector2d::Constant(kMargin_px);
      const Eigen::Vector2d from_axis_mm = camera(position_px<frame::Image>(u_px)).in_mm();
      data.views.push_back(
          {position_mm<frame::Machine>(Eigen::Vector2d(100, 80) - from_axis_mm), 0});
      sights.names.push_back(fmt::format("view {}", sights.names.size()));
      test::see(camera, {Eigen::Vector2d(0, 0)}, pose, data.views.size() - 1, data);
    }
  }
  Random random(seed);
  test::add_noise(random, noise_px, data);
  for (CameraObservation& seen : data.seen) {
    seen.seen.cov = kStated_px * kStated_px * Eigen::Matrix2d::Identity();
  }
  return sights;
}

void move(MarkSights& sights, std::size_t i, const Eigen::Vector2d& by_px) {
  auto& position = sights.data.seen.at(i).seen.position;
  position = position + displacement_px<frame::Image>(by_px);
}

TEST(CameraScatter, OfFewViewsGrowsSigmasAsStudentsTDoes) {
  const auto run = fit_camera_run(MachineConfig(), sights_of(3, kNoise_px, 21), {});
  ASSERT_TRUE(run) << run.error().text();
  // 18 coordinates; the mark takes 2 and a radial camera 3.
  const double nu = 13;
  ASSERT_EQ(run->fit.degrees_of_freedom, 13);
  EXPECT_GT(run->excess, 2);
  EXPECT_NEAR(run->sigma_factor, run->excess * std::sqrt(nu / (nu - 2)), 1e-6);
  // The covariance is that of the stated noise, times the factor's square.
  CameraFitOptions stated;
  stated.form = CameraForm::Radial;
  stated.axis_px = kAxis_px;
  const auto plain = fit_camera(sights_of(3, kNoise_px, 21).data, stated);
  ASSERT_TRUE(plain) << plain.error().text();
  EXPECT_NEAR(std::sqrt(run->fit.covariance(0, 0) / plain->covariance(0, 0)),
              run->sigma_factor,
              1e-3 * run->sigma_factor);
  EXPECT_THAT(report(*run),
              HasSubstr(fmt::format("; views scatter {:.2f} times more than stated; sigmas grow "
                                    "{:.2f} times by the views' scatter and number\n",
                                    run->excess,
                                    run->sigma_factor)));
}

TEST(CameraScatter, IsThatOfTheSoftestFormAndNotTheLeastOfSeveral) {
  // Of a camera with a focal length five forms can be fitted. The one of least scatter is an
  // estimate that is too small: 9 views would be off by 1.6 to 1.9 in chi square.
  CameraRunOptions near;
  near.focal_px = 5000;
  const auto run = fit_camera_run(MachineConfig(), sights_of(3, kNoise_px, 22), near);
  ASSERT_TRUE(run) << run.error().text();
  EXPECT_EQ(run->fit.form, CameraForm::Tangential);
  ASSERT_EQ(run->fit.degrees_of_freedom, 8);
  // After the sigmas have grown, chi square is what they were divided by.
  EXPECT_NEAR(run->fit.chi_square, 6, 1e-3);
}

TEST(CameraScatter, OfSoundViewsIsNoReasonToLeaveOneOut) {
  // The median of nine lengths is off by a third as a rule. With it alone as the judge, 18 % of
  // such calibrations lost up to three views.
  constexpr int kDraws = 100;
  int lost = 0;
  for (int trial = 0; trial < kDraws; ++trial) {
    MarkSights sights = sights_of(3, kNoise_px, static_cast<std::uint64_t>(400 + trial));
    CameraFitOptions options;
    options.axis_px = kAxis_px;
    const auto n = internal::leave_out_outliers(options, sights);
    ASSERT_TRUE(n) << n.error().text();
    lost += *n > 0;
    EXPECT_EQ(sights.data.seen.size() + static_cast<std::size_t>(*n), 9U);
    EXPECT_EQ(sights.missed.size(), static_cast<std::size_t>(*n));
  }
  // One in a thousand is expected; two of a hundred come by chance in 0.5 % of the seeds.
  EXPECT_LE(lost, 1);
}

TEST(CameraScatter, DoesNotHideASpeckAmongNineViews) {
  MarkSights sights = sights_of(3, kNoise_px, 23);
  move(sights, 4, {2, -1});
  const auto run = fit_camera_run(MachineConfig(), sights, {});
  ASSERT_TRUE(run) << run.error().text();
  EXPECT_EQ(run->n_left_out, 1) << report(*run);
  EXPECT_THAT(report(*run), HasSubstr("  without view 4: it does not fit the others: "));
  EXPECT_LT(run->excess, 2 * kNoise_px / kStated_px);
}

TEST(CameraScatter, DoesNotHideAViewOfAnotherMark) {
  MarkSights sights = sights_of(5, kStated_px, 24);
  move(sights, 7, {300, -200});
  const auto run = fit_camera_run(MachineConfig(), sights, {});
  ASSERT_TRUE(run) << run.error().text();
  EXPECT_EQ(run->n_left_out, 1) << report(*run);
  EXPECT_LT(run->excess, 1.5);
}

TEST(CameraScatter, ReportNamesTheStifferCameraThatWouldDo) {
  const auto softest = fit_camera_run(MachineConfig(), sights_of(5, kStated_px, 25), {});
  ASSERT_TRUE(softest) << softest.error().text();
  EXPECT_EQ(softest->fit.form, CameraForm::Radial);
  EXPECT_THAT(report(*softest), HasSubstr("; a flat camera would do"));
  const auto flat =
      fit_camera_run(MachineConfig(), sights_of(5, kStated_px, 25), {.form = CameraForm::Flat});
  ASSERT_TRUE(flat) << flat.error().text();
  EXPECT_THAT(report(*flat), Not(HasSubstr("would do")));
}

}  // namespace
}  // namespace panelcal
