// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "tests/vision/polygon/trial.h"

namespace panelcal::test {
namespace {

struct Picture {
  CellTrial trial;
  Image image;
};

Picture picture_of(const CellTrialOptions& options) {
  Random random(5);
  const CellTrial trial = draw_cell_trial(options, random);
  return {trial, render(trial.scene, trial.camera, random)};
}

bool says(const Detection& detection, std::string_view words) {
  return detection.reason.find(words) != std::string::npos;
}

TEST(CellDetector, MeasuresACrossWithAllItsFigures) {
  CellTrialOptions options;
  options.shape = Shape::Cross;
  options.with_mapping = true;
  const Picture p = picture_of(options);
  const Detection detection = locate(p.image, p.trial.target, &p.trial.camera.mapping);
  ASSERT_EQ(detection.status, DetectionStatus::Found) << detection.reason;
  const TargetFit& fit = *detection.best;
  EXPECT_LT((fit.center.position.in_px() - p.trial.center_px).norm(), 0.02);
  EXPECT_NEAR(fit.size_mm->in_mm(), p.trial.size_px * 0.01, 2e-4);
  EXPECT_NEAR(fit.angle.in_rad(), p.trial.angle_rad, 5 * fit.angle_sigma.in_rad());
  EXPECT_NEAR(fit.contrast, 140, 1);
  EXPECT_NEAR(fit.background, 60, 1);
  EXPECT_NEAR(fit.noise, 2, 0.2);
  EXPECT_NEAR(fit.blur_px, std::sqrt(1 + 1.0 / 12), 0.02);
  EXPECT_GT(fit.score, 0.98);
  ASSERT_EQ(fit.outlines_px.size(), 1U);
  EXPECT_EQ(fit.outlines_px[0].size(), 12U);
}

TEST(CellDetector, AWrongSizeIsRejectedWithFigures) {
  const Picture p = picture_of({});
  Target target = p.trial.target;
  target.size_px = px(75);
  const Detection detection = locate(p.image, target);
  EXPECT_EQ(detection.status, DetectionStatus::Rejected);
  EXPECT_TRUE(says(detection, "its size is 80")) << detection.reason;
}

TEST(CellDetector, AWrongWidthIsRejectedWithFigures) {
  CellTrialOptions options;
  options.shape = Shape::Cross;
  const Picture p = picture_of(options);
  Target target = p.trial.target;
  target.width_px = px(22);
  const Detection detection = locate(p.image, target);
  EXPECT_EQ(detection.status, DetectionStatus::Rejected);
  EXPECT_TRUE(says(detection, "its width is 24")) << detection.reason;
}

TEST(CellDetector, TooLargeATurnIsRejectedWithFigures) {
  CellTrialOptions options;
  options.max_angle_deg = 0;
  const Picture p = picture_of(options);
  Target target = p.trial.target;
  target.angle = deg(-7);
  const Detection detection = locate(p.image, target);
  EXPECT_EQ(detection.status, DetectionStatus::Rejected);
  EXPECT_TRUE(says(detection, "it is turned by +7.0")) << detection.reason;
}

TEST(CellDetector, AnyTurnIsFoundIfItIsAllowed) {
  CellTrialOptions options;
  options.max_angle_deg = 45;
  options.n = 12;
  const CellStatistics s = [&] {
    CellStatistics all;
    for (int i = 0; i < options.n; ++i) {
      Random random = Random(9).fork(static_cast<std::uint64_t>(i));
      CellTrial trial = draw_cell_trial(options, random);
      trial.target.angle_tolerance = deg(45);
      const Detection detection = locate(render(trial.scene, trial.camera, random), trial.target);
      all.n_found += detection.status == DetectionStatus::Found;
    }
    return all;
  }();
  EXPECT_EQ(s.n_found, options.n);
}

/// The search sees a large target much reduced, its edges sharper than a pixel: wherever they fall
/// between the reduced pixels, it must see it.
TEST(CellDetector, LargeTargetsAreFoundAtAnyPlace) {
  for (const double size_px : {120.0, 160.0}) {
    for (const int shift_px : {0, 1, 2, 3}) {
      CellTrialOptions options;
      options.size_px = size_px;
      options.picture_px = 281;
      options.max_angle_deg = 0;
      Random random(5);
      CellTrial trial = draw_cell_trial(options, random);
      const Eigen::Vector2d at_px(140 + shift_px, 140);
      trial.scene.features[0].center = trial.camera.mapping(position_px<frame::Image>(at_px));
      const Detection detection = locate(render(trial.scene, trial.camera, random), trial.target);
      ASSERT_EQ(detection.status, DetectionStatus::Found) << size_px << detection.reason;
      EXPECT_LT((detection.best->center.position.in_px() - at_px).norm(), 0.02);
    }
  }
}

/// A square's plain face says nothing of how much the ground around it varies.
TEST(CellDetector, StrongWeaveIsNotTakenForDebris) {
  CellTrialOptions options;
  options.contrast = 100;
  options.noise = 5;
  options.blur_px = 1.5;
  options.weave = 21;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Random random(seed);
    const CellTrial trial = draw_cell_trial(options, random);
    const Detection detection = locate(render(trial.scene, trial.camera, random), trial.target);
    ASSERT_EQ(detection.status, DetectionStatus::Found) << seed << detection.reason;
    EXPECT_LT(detection.best->excluded, 0.02) << seed;
  }
}

TEST(CellDetector, ASquareAtTheBorderIsRejected) {
  CellTrialOptions options;
  Random random(5);
  CellTrial trial = draw_cell_trial(options, random);
  trial.scene.features[0].center = trial.camera.mapping(position_px<frame::Image>({100, 36}));
  const Detection detection = locate(render(trial.scene, trial.camera, random), trial.target);
  EXPECT_NE(detection.status, DetectionStatus::Found);
}

TEST(CellDetector, TwoSquaresAreAmbiguous) {
  CellTrialOptions options;
  options.size_px = 50;
  Random random(5);
  CellTrial trial = draw_cell_trial(options, random);
  Feature second = trial.scene.features[0];
  second.center = trial.camera.mapping(position_px<frame::Image>({45, 45}));
  trial.scene.features.push_back(second);
  trial.scene.features[0].center = trial.camera.mapping(position_px<frame::Image>({150, 140}));
  const Detection detection = locate(render(trial.scene, trial.camera, random), trial.target);
  EXPECT_EQ(detection.status, DetectionStatus::Ambiguous) << detection.reason;
}

TEST(CellDetector, SaturatedTargetsAreMeasured) {
  CellTrialOptions options;
  options.contrast = 230;  // on 60: beyond the scale's end
  options.n = 20;
  const CellStatistics s = run_cell_trials(options);
  EXPECT_EQ(s.n_found, s.n) << s.first_failure;
  EXPECT_LT(s.worst, 0.02) << s.text();
}

TEST(CellDetector, AHalfHiddenSquareIsNotFound) {
  CellTrialOptions options;
  Random random(5);
  CellTrial trial = draw_cell_trial(options, random);
  Feature cover = cell_feature(Shape::Square, 1.2, 0, 0, trial.scene.background);
  cover.center =
      trial.camera.mapping(position_px<frame::Image>(trial.center_px + Eigen::Vector2d(62, 0)));
  trial.scene.features.push_back(cover);
  const Detection detection = locate(render(trial.scene, trial.camera, random), trial.target);
  EXPECT_NE(detection.status, DetectionStatus::Found);
}

}  // namespace
}  // namespace panelcal::test
