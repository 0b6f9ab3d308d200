// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/fit/fit.h"

#include <cmath>
#include <cstdint>
#include <limits>

#include <gmock/gmock.h>

#include "tests/calib/camera/simulated_camera.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::IsNearMatrix;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr double kNoise_px = 0.02;

CameraFitOptions options_for(const CameraModel::Parameters& truth, CameraForm form) {
  CameraFitOptions options;
  options.form = form;
  options.axis_px = truth.axis_px;
  options.focal_px = truth.focal_px;
  options.rotation_rad = truth.rotation_rad;
  return options;
}

/// Greatest distance, px, of what two cameras show of one place, once the shift and turn is taken
/// away by which a plate of unknown pose may be off.
double greatest_difference_px(const CameraModel& a, const CameraModel& b) {
  double greatest = 0;
  for (double x = 20; x <= 620; x += 60) {
    for (double y = 20; y <= 460; y += 55) {
      const Position<frame::Image> u = position_px(x, y);
      const Eigen::Vector2d off_mm = a(u).in_mm() - b(u).in_mm();
      greatest = std::max(greatest, off_mm.norm() / b.parameters().scale_mm_per_px);
    }
  }
  return greatest;
}

void give_sigma(CameraData& data, double sigma_px) {
  for (CameraObservation& seen : data.seen) {
    seen.seen.cov = sigma_px * sigma_px * Eigen::Matrix2d::Identity();
  }
}

TEST(CameraFit, FindsTheCameraOfExactViews) {
  const CameraModel truth(test::bent_camera());
  CameraData data = test::plate_views(truth, mm(0));
  give_sigma(data, kNoise_px);
  const auto fit = fit_camera(data, options_for(truth.parameters(), CameraForm::Tangential));
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_THAT(fit->undetermined, ElementsAre(CameraParameter::Rotation));
  EXPECT_LT(greatest_difference_px(fit->model(), truth), 1e-6);
  EXPECT_LT(fit->rms_px, 1e-7);
  EXPECT_NEAR(fit->parameters.tilt.x(), truth.parameters().tilt.x(), 1e-8);
  EXPECT_EQ(fit->degrees_of_freedom, 2 * static_cast<int>(data.seen.size()) - 7 - 3 * 5);
}

TEST(CameraFit, FindsTheCameraFromOneTargetAtKnownPlaces) {
  const CameraModel truth(test::bent_camera());
  CameraData data = test::target_views(truth, 11, mm(0));
  give_sigma(data, kNoise_px);
  CameraFitOptions options = options_for(truth.parameters(), CameraForm::Tangential);
  options.rotation_rad = 0;  // the stage's moves show it
  options.scale_mm_per_px = 1;
  const auto fit = fit_camera(data, options);
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_THAT(fit->undetermined, IsEmpty());
  EXPECT_LT(greatest_difference_px(fit->model(), truth), 1e-6);
  EXPECT_EQ(fit->degrees_of_freedom, 2 * static_cast<int>(data.seen.size()) - 8 - 2);
}

TEST(CameraFit, PredictsHeldOutDots) {
  const CameraModel truth(test::bent_camera());
  CameraData data = test::plate_views(truth, mm(0.15));
  Random random(11);
  test::add_noise(random, kNoise_px, data);
  const auto fit = fit_camera(data, options_for(truth.parameters(), CameraForm::Tangential));
  ASSERT_TRUE(fit) << fit.error().text();
  ASSERT_TRUE(fit->held_out_rms_px);
  EXPECT_GT(fit->n_held_out, 50U);
  EXPECT_LE(*fit->held_out_rms_px, 0.030);  // 0.028 is the noise of two coordinates
  EXPECT_LE(greatest_difference_px(fit->model(), truth), 0.03);
  EXPECT_NEAR(fit->chi_square / fit->degrees_of_freedom, 1, 0.15);
}

TEST(CameraFit, CountsTheBiasOfCircleCenters) {
  // Dots of 0.25 mm radius under a tilt of 0.1 and a bent lens: a fit that takes them for points
  // shows the difference.
  CameraModel::Parameters p = test::bent_camera();
  p.tilt = {0.1, 0.04};
  p.focal_px = 2000;
  p.k1_per_px2 = 1e-7;
  const CameraModel truth(p);
  CameraData data = test::plate_views(truth, mm(0.25));
  give_sigma(data, kNoise_px);
  const CameraFitOptions options = options_for(p, CameraForm::Tangential);
  const auto counted = fit_camera(data, options);
  for (PlateDot& dot : data.dots) dot.radius = mm(0);
  const auto ignored = fit_camera(data, options);
  ASSERT_TRUE(counted && ignored);
  EXPECT_LT(greatest_difference_px(counted->model(), truth), 0.001);
  EXPECT_GT(greatest_difference_px(ignored->model(), truth), 0.02);
}

TEST(CameraFit, SaysThatScaleAndRotationAreOpenWithoutStageAndCertificate) {
  const CameraModel truth(test::bent_camera());
  CameraData data = test::plate_views(truth, mm(0));
  for (PlateDot& dot : data.dots) dot.is_certified = false;
  give_sigma(data, kNoise_px);
  CameraFitOptions options = options_for(truth.parameters(), CameraForm::TiltedRadial);
  options.scale_mm_per_px = truth.parameters().scale_mm_per_px;
  const auto fit = fit_camera(data, options);
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_THAT(fit->undetermined, ElementsAre(CameraParameter::Scale, CameraParameter::Rotation));
  EXPECT_EQ(fit->covariance(0, 0), 0);
}

TEST(CameraFit, FindsTheLensFromAnUncertifiedPlateAlone) {
  const CameraModel truth(test::bent_camera());
  CameraData data = test::plate_views(truth, mm(0));
  // The drawing is off by 10 um here and there.
  Random random(12);
  for (PlateDot& dot : data.dots) {
    const double x_mm = 0.01 * random.normal();
    const double y_mm = 0.01 * random.normal();
    dot.is_certified = false;
    dot.place = dot.place + displacement_mm<frame::Plate>(x_mm, y_mm);
  }
  give_sigma(data, kNoise_px);
  CameraFitOptions options = options_for(truth.parameters(), CameraForm::Tangential);
  options.scale_mm_per_px = truth.parameters().scale_mm_per_px;
  const auto fit = fit_camera(data, options);
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_LT(greatest_difference_px(fit->model(), truth), 1e-5);
}

TEST(CameraFit, SaysThatATelecentricLensShowsNoTilt) {
  CameraModel::Parameters p = test::straight_camera();
  p.focal_px = std::numeric_limits<double>::infinity();
  CameraData data = test::target_views(CameraModel(p), 5, mm(0));
  give_sigma(data, kNoise_px);
  const auto fit = fit_camera(data, options_for(p, CameraForm::Tilted));
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_THAT(fit->undetermined, ElementsAre(CameraParameter::TiltX, CameraParameter::TiltY));
}

TEST(CameraFit, OneDotInOneViewDeterminesNothing) {
  CameraData data = test::target_views(CameraModel(test::straight_camera()), 5, mm(0));
  data.seen.resize(1);
  give_sigma(data, kNoise_px);
  const auto fit = fit_camera(data, options_for(test::straight_camera(), CameraForm::Flat));
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_THAT(fit->undetermined, ElementsAre(CameraParameter::Scale, CameraParameter::Rotation));
  EXPECT_FALSE(fit->held_out_rms_px);
}

TEST(CameraFit, IsHardlyMovedByDirtIfAsked) {
  const CameraModel truth(test::bent_camera());
  CameraData data = test::plate_views(truth, mm(0));
  Random random(13);
  test::add_noise(random, kNoise_px, data);
  for (std::size_t i = 0; i < data.seen.size(); i += 40) {
    data.seen[i].seen.position =
        data.seen[i].seen.position + displacement_px<frame::Image>(Eigen::Vector2d(3, -2));
  }
  CameraFitOptions options = options_for(truth.parameters(), CameraForm::Tangential);
  const auto plain = fit_camera(data, options);
  options.huber_sigmas = 1.35;
  const auto robust = fit_camera(data, options);
  ASSERT_TRUE(plain && robust);
  EXPECT_GT(greatest_difference_px(plain->model(), truth), 0.2);
  EXPECT_LT(greatest_difference_px(robust->model(), truth), 0.06);
}

TEST(ChooseCamera, NeedsTheTermsThatTheDataNeed) {
  struct Case {
    CameraForm expected;
    CameraModel::Parameters truth;
  };
  std::vector<Case> cases(5, {CameraForm::Flat, test::straight_camera()});
  for (std::size_t i = 0; i < cases.size(); ++i) cases[i].expected = kCameraForms[i];
  const CameraModel::Parameters bent = test::bent_camera();
  for (std::size_t i = 1; i < 5; ++i) cases[i].truth.k1_per_px2 = 2 * bent.k1_per_px2;
  for (std::size_t i = 2; i < 5; ++i) cases[i].truth.tilt = bent.tilt;
  for (std::size_t i = 3; i < 5; ++i) cases[i].truth.k2_per_px4 = -2 * bent.k2_per_px4;
  cases[4].truth.p1_per_px = bent.p1_per_px;
  for (const Case& c : cases) {
    CameraData data = test::plate_views(CameraModel(c.truth), mm(0));
    Random random(14);
    test::add_noise(random, kNoise_px, data);
    const auto fit = choose_camera(data, options_for(c.truth, CameraForm::Flat));
    ASSERT_TRUE(fit) << fit.error().text();
    // Softer by one time in ten, from noise: see fit_slow_test.cc.
    EXPECT_GE(fit->sufficient, c.expected) << name(fit->sufficient);
    EXPECT_EQ(fit->form, CameraForm::Tangential);
    EXPECT_LE(*fit->held_out_rms_px, 0.031);
  }
}

/// 640 x 480 px through a telecentric lens, which shows no tilt.
CameraModel::Parameters telecentric_camera() {
  CameraModel::Parameters p = test::straight_camera();
  p.focal_px = std::numeric_limits<double>::infinity();
  return p;
}

TEST(ChooseCamera, TakesNoFormThatLeavesTooFewDegreesOfFreedom) {
  const CameraModel::Parameters p = telecentric_camera();
  CameraData data = test::target_views(CameraModel(p), 4, mm(0));
  give_sigma(data, kNoise_px);
  const CameraFitOptions options = options_for(p, CameraForm::Flat);
  const auto radial = choose_camera(data, options);
  ASSERT_TRUE(radial) << radial.error().text();
  EXPECT_EQ(radial->form, CameraForm::Radial);
  EXPECT_EQ(radial->sufficient, CameraForm::Flat);
  EXPECT_FALSE(radial->wants_views_for);
  // The mark takes 2 coordinates and a radial camera 3.
  EXPECT_EQ(radial->degrees_of_freedom, 2 * static_cast<int>(data.seen.size()) - 5);
  // Four views leave three of them; of three views' six a flat camera leaves two, which is all
  // there is.
  data.seen.resize(4);
  EXPECT_EQ(choose_camera(data, options)->form, CameraForm::Radial);
  data.seen.resize(3);
  const auto flat = choose_camera(data, options);
  ASSERT_TRUE(flat) << flat.error().text();
  EXPECT_EQ(flat->form, CameraForm::Flat);
  EXPECT_EQ(flat->degrees_of_freedom, 2);
  EXPECT_EQ(flat->wants_views_for, CameraForm::Radial);
}

TEST(ChooseCamera, FreesWhatATelecentricLensHidesOnlyWhereItShows) {
  // Decentering of 0.3 px at the corners puts a radial camera 4 um off there.
  CameraModel::Parameters p = telecentric_camera();
  const CameraFitOptions options = options_for(p, CameraForm::Flat);
  CameraData straight = test::target_views(CameraModel(p), 5, mm(0));
  p.p1_per_px = 1e-6;
  p.p2_per_px = -1e-6;
  const CameraModel truth(p);
  CameraData off_center = test::target_views(truth, 5, mm(0));
  Random random(16);
  test::add_noise(random, kNoise_px, straight);
  test::add_noise(random, kNoise_px, off_center);
  const auto sound = choose_camera(straight, options);
  ASSERT_TRUE(sound) << sound.error().text();
  EXPECT_EQ(sound->form, CameraForm::Radial);
  EXPECT_THAT(sound->undetermined, IsEmpty());
  const auto bent = choose_camera(off_center, options);
  ASSERT_TRUE(bent) << bent.error().text();
  EXPECT_EQ(bent->form, CameraForm::Tangential);
  EXPECT_THAT(bent->undetermined, ElementsAre(CameraParameter::TiltX, CameraParameter::TiltY));
  EXPECT_LT(greatest_difference_px(bent->model(), truth), 0.1);
  // Noise that is five times the stated is no lens.
  give_sigma(straight, kNoise_px / 5);
  const auto noisy = choose_camera(straight, options);
  ASSERT_TRUE(noisy) << noisy.error().text();
  EXPECT_EQ(noisy->form, CameraForm::Radial);
}

TEST(ChooseCamera, OneViewOfACertifiedPlateLeavesTheRotationOpenAndNoTiltThroughATelecentricLens) {
  CameraModel::Parameters p = telecentric_camera();
  p.k1_per_px2 = 1e-8;
  CameraData data = test::plate_views(CameraModel(p), mm(0));
  std::erase_if(data.seen, [](const CameraObservation& seen) { return seen.i_view != 0; });
  data.views.resize(1);
  Random random(17);
  test::add_noise(random, kNoise_px, data);
  const auto fit = choose_camera(data, options_for(p, CameraForm::Flat));
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_EQ(fit->form, CameraForm::Radial);
  EXPECT_THAT(fit->undetermined, ElementsAre(CameraParameter::Rotation));
  EXPECT_NEAR(
      fit->parameters.scale_mm_per_px, p.scale_mm_per_px, 4 * std::sqrt(fit->covariance(0, 0)));
  EXPECT_NEAR(fit->parameters.k1_per_px2, p.k1_per_px2, 4 * std::sqrt(fit->covariance(4, 4)));
}

TEST(ChooseCamera, IsCheckedOnlyByPlacesThatOtherViewsPredict) {
  // Nine views of the middle and one of a corner, which is held out: without it a tangential camera
  // is wild there, and may not show the place at all.
  const CameraModel::Parameters p = test::straight_camera();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CameraData data = test::target_views(CameraModel(p), 3, mm(0));
    for (PlateView& view : data.views) {
      const Eigen::Vector2d from_middle_mm = view.axis_at.in_mm() - Eigen::Vector2d(100.3, 80.7);
      view.axis_at =
          position_mm<frame::Machine>(Eigen::Vector2d(100.3, 80.7) + from_middle_mm * 0.2);
    }
    data.views.push_back({position_mm<frame::Machine>(97.4, 78.6), 0});
    data.seen.clear();
    for (std::size_t i = 0; i < data.views.size(); ++i) {
      test::see(CameraModel(p), {Eigen::Vector2d(0, 0)}, {0, {100.3, 80.7}}, i, data);
    }
    ASSERT_EQ(data.seen.size(), 10u);
    Random random(seed);
    test::add_noise(random, kNoise_px, data);
    const auto fit = choose_camera(data, options_for(p, CameraForm::Flat));
    ASSERT_TRUE(fit) << fit.error().text();
    EXPECT_EQ(fit->n_held_out, 1u) << "seed " << seed;
    ASSERT_TRUE(fit->held_out_rms_px);
    EXPECT_LT(*fit->held_out_rms_px, 10 * kNoise_px) << "seed " << seed;
  }
}

TEST(ChooseCamera, AFormThatIsAskedForSuffices) {
  const CameraModel::Parameters p = test::straight_camera();
  CameraData data = test::target_views(CameraModel(p), 4, mm(0));
  give_sigma(data, kNoise_px);
  const auto fit = fit_camera(data, options_for(p, CameraForm::Tilted));
  ASSERT_TRUE(fit) << fit.error().text();
  EXPECT_EQ(fit->sufficient, CameraForm::Tilted);
}

TEST(CameraFit, RefusesWhatIsNoData) {
  const CameraModel::Parameters p = test::straight_camera();
  const CameraFitOptions options = options_for(p, CameraForm::Flat);
  CameraData good = test::target_views(CameraModel(p), 4, mm(0));
  give_sigma(good, kNoise_px);
  const double nan = std::numeric_limits<double>::quiet_NaN();

  EXPECT_THAT(fit_camera({}, options), FailsWith(Code::CalibrationData));
  CameraData data = good;
  data.seen[3].i_dot = 1;
  EXPECT_THAT(fit_camera(data, options), FailsWith(Code::CalibrationData, "observation 3"));
  data = good;
  data.seen[2].seen.cov(0, 0) = -1;
  EXPECT_THAT(fit_camera(data, options), FailsWith(Code::CalibrationData, "observation 2"));
  data = good;
  data.seen[2].seen.position = position_px(nan, 0);
  EXPECT_THAT(fit_camera(data, options), FailsWith(Code::CalibrationData, "observation 2"));
  data = good;
  data.views[0].i_pose = 1000;
  EXPECT_THAT(fit_camera(data, options), FailsWith(Code::CalibrationData, "pose 1000"));
  data = good;
  data.dots[0].radius = mm(nan);
  EXPECT_THAT(fit_camera(data, options), FailsWith(Code::CalibrationData, "radius"));
  CameraFitOptions bad = options;
  bad.focal_px = nan;
  EXPECT_THAT(fit_camera(good, bad), FailsWith(Code::CalibrationData, "focal_px"));
  bad = options;
  bad.held_out_every = 1;
  EXPECT_THAT(fit_camera(good, bad), FailsWith(Code::CalibrationData, "held_out_every"));
}

TEST(CameraFit, SurvivesAMixUp) {
  // Observations given to dots at random: whatever comes of it, it is no crash, and not accepted.
  const CameraModel truth(test::straight_camera());
  CameraData data = test::plate_views(truth, mm(0));
  give_sigma(data, kNoise_px);
  Random random(15);
  for (CameraObservation& seen : data.seen) {
    seen.i_dot = static_cast<std::size_t>(random.uniform(0, 81));
  }
  const auto fit = fit_camera(data, options_for(truth.parameters(), CameraForm::TiltedRadial));
  if (fit) {
    EXPECT_GT(fit->chi_square, 100.0 * fit->degrees_of_freedom);
  }
}

}  // namespace
}  // namespace panelcal
