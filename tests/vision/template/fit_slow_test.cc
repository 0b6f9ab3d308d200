// SPDX-License-Identifier: Apache-2.0
// Truth first: templates that have noise themselves, found in rendered pictures.
#include <cmath>
#include <iostream>

#include "vision/locate/locate.h"
#include <gtest/gtest.h>

#include "tests/vision/template/trial.h"

namespace panelcal::test {
namespace {

/// As issue 5 asks; 300 draws of two numbers each have a standard deviation of 0.06.
constexpr double kLowNees = 0.9;
constexpr double kHighNees = 1.1;
/// The same for the single number of the angle, three standard deviations.
constexpr double kAngleNeesTolerance = 0.3;

TemplateStatistics run_and_show(const TemplateTrialOptions& options) {
  const TemplateStatistics s = run_template_trials(options);
  std::cout << s.text() << '\n';
  EXPECT_EQ(s.n_found, s.n) << s.first_failure;
  return s;
}

void expect_honest(const TemplateStatistics& s) {
  EXPECT_GT(s.nees, kLowNees) << s.text();
  EXPECT_LT(s.nees, kHighNees) << s.text();
}

void expect_half_of_the_peer(const TemplateStatistics& s) {
  EXPECT_LT(s.rmse_px.x(), 0.5 * s.peer_rmse_px.x()) << s.text();
  EXPECT_LT(s.rmse_px.y(), 0.5 * s.peer_rmse_px.y()) << s.text();
}

TEST(TemplateAccuracy, CleanPicturesReachTheBound) {
  const TemplateStatistics s = run_and_show({});
  // 300 draws: one standard deviation of an rmse is 4 %.
  EXPECT_LT(s.rmse.maxCoeff(), 1.12) << s.text();
  expect_honest(s);
  EXPECT_NEAR(s.angle_nees, 1, kAngleNeesTolerance) << s.text();
  expect_half_of_the_peer(s);
}

/// Not turned, so that all pixels lie at the same fraction between the template's: where a fit that
/// trusts its noisy template is pulled to halves of pixels.
TEST(TemplateAccuracy, PixelPhaseOfUnturnedMarksDoesNotMatter) {
  TemplateTrialOptions options;
  options.seed = 4;
  options.max_turn_deg = 0;
  options.with_mapping = false;
  const TemplateStatistics s = run_and_show(options);
  EXPECT_LT(s.rmse.maxCoeff(), 1.12) << s.text();
  expect_honest(s);
  // This one is fair to matchTemplate, which does not turn.
  expect_half_of_the_peer(s);
}

TEST(TemplateAccuracy, TypicalPicturesAreNearTheBound) {
  TemplateTrialOptions options;
  options.seed = 2;
  options.contrast = 100;
  options.noise = options.template_noise = 5;
  options.blur_px = options.template_blur_px = 1.5;
  options.light_gradient = 0.3;
  const TemplateStatistics s = run_and_show(options);
  EXPECT_LT(s.rmse.maxCoeff(), 1.25) << s.text();
  expect_honest(s);
  expect_half_of_the_peer(s);
}

/// The noise of the template counts in full although only one picture has it.
TEST(TemplateAccuracy, CovarianceKnowsTheTemplatesNoise) {
  TemplateTrialOptions options;
  options.seed = 3;
  options.template_noise = 8;
  const TemplateStatistics s = run_and_show(options);
  EXPECT_LT(s.rmse.maxCoeff(), 1.25) << s.text();
  EXPECT_GT(s.nees, 0.75) << s.text();
  EXPECT_LT(s.nees, kHighNees) << s.text();
}

TEST(TemplateAccuracy, SlightlyOtherFocusCostsLittle) {
  TemplateTrialOptions options;
  options.seed = 5;
  options.blur_px = 1.3;
  const TemplateStatistics s = run_and_show(options);
  EXPECT_LT(s.rmse.maxCoeff(), 1.3) << s.text();
}

TEST(TemplateAccuracy, DebrisIsLeftOut) {
  TemplateTrialOptions options;
  options.seed = 6;
  options.n = 200;
  options.n_debris = 2;
  const TemplateStatistics s = run_template_trials(options);
  std::cout << s.text() << '\n';
  EXPECT_GE(s.n_found, 0.99 * s.n) << s.first_failure;
  EXPECT_LT(s.rmse.maxCoeff(), 1.3) << s.text();
  EXPECT_GT(s.nees, 0.75) << s.text();
  EXPECT_LT(s.nees, 1.25) << s.text();
}

TEST(TemplateAccuracy, OnWeaveTheCovarianceIsNotTooSmall) {
  TemplateTrialOptions options;
  options.seed = 8;
  options.n = 200;
  options.weave = 8;
  const TemplateStatistics s = run_and_show(options);
  EXPECT_LT(s.nees, 1.3) << s.text();
}

/// The mark's own parts and others, at random: everything but their arrangement.
Scene other_scene(const TemplateTrial& trial, Random& random) {
  Scene scene = trial.scene;
  scene.weave.amplitude = random.uniform() < 0.5 ? 0 : 8.0 / 255;
  const auto parts = scene.features;
  scene.features.clear();
  const int n_parts = 2 + static_cast<int>(random.uniform(0, 6));
  for (int i = 0; i < n_parts; ++i) {
    Feature feature = parts[static_cast<std::size_t>(random.uniform(0, 4))];
    feature.center = trial.camera.mapping(position_px<frame::Image>(
        trial.pose.center_px + Eigen::Vector2d(random.uniform(-45, 45), random.uniform(-45, 45))));
    feature.size = random.uniform(0.7, 1.4) * feature.size;
    feature.angle = rad(random.uniform(0, 3.14));
    scene.features.push_back(feature);
  }
  return scene;
}

TEST(TemplateAccuracy, OtherPicturesAreNotFound) {
  constexpr int kTrials = 500;
  int n_found = 0;
  for (int i = 0; i < kTrials; ++i) {
    Random random = Random(20).fork(static_cast<std::uint64_t>(i));
    const TemplateTrial trial = draw_template_trial({}, random);
    const Image image = render(other_scene(trial, random), trial.camera, random);
    const Detection d = locate(image, trial.target, &trial.camera.mapping);
    const bool is_found =
        d.status == DetectionStatus::Found || d.status == DetectionStatus::Ambiguous;
    n_found += is_found;
    if (is_found) std::cout << "draw " << i << ": score " << d.best->score << '\n';
  }
  EXPECT_EQ(n_found, 0);
}

}  // namespace
}  // namespace panelcal::test
