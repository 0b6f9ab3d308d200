// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <gtest/gtest.h>

#include "tests/vision/polygon/trial.h"

namespace panelcal::test {
namespace {

constexpr double kScaleMm = 0.01;  // per px

CellTrialOptions slot_options() {
  CellTrialOptions options;
  options.shape = Shape::Slot;
  options.size_px = 40;
  return options;
}

/// A slot of 40 px width that ends in the picture: a stadium of this length.
Image picture_of_stadium(double length_px) {
  Random random(3);
  CellTrial trial = draw_cell_trial(slot_options(), random);
  Feature& slot = trial.scene.features[0];
  slot.shape = Feature::Shape::Stadium;
  slot.size = mm(length_px * kScaleMm);
  slot.inner_size = mm(40 * kScaleMm);
  return render(trial.scene, trial.camera, random);
}

Target slot_target() {
  Target target;
  target.shape = Shape::Slot;
  target.size_px = px(40);
  return target;
}

TEST(SlotDetector, TellsTheCoordinateAcrossAndNothingElse) {
  Random random(1);
  const CellTrial trial = draw_cell_trial(slot_options(), random);
  const Detection detection = locate(render(trial.scene, trial.camera, random), trial.target);
  ASSERT_EQ(detection.status, DetectionStatus::Found) << detection.reason;
  const TargetFit& fit = *detection.best;
  const double turn = trial.angle_rad;
  const Eigen::Vector2d along(std::cos(turn), std::sin(turn));
  const Eigen::Vector2d across(-along.y(), along.x());
  EXPECT_LT(std::abs(across.dot(fit.center.position.in_px() - trial.center_px)), 0.01);
  EXPECT_LT(std::sqrt(across.dot(fit.center.cov * across)), 0.01);
  // Uniform over the visible length, most of the 200 px of the picture.
  const double seen_px = std::sqrt(12 * along.dot(fit.center.cov * along));
  EXPECT_GT(seen_px, 150);
  EXPECT_LT(seen_px, 210);
  ASSERT_TRUE(fit.blind_direction.has_value());
  EXPECT_NEAR(fit.blind_direction->in_rad(), turn, 1e-3);
  EXPECT_NEAR(fit.size.in_px(), 40, 0.05);
}

TEST(SlotDetector, ReportsThePlaceNearestToTheSearchAreasCentre) {
  Random random(1);
  const CellTrial trial = draw_cell_trial(slot_options(), random);
  LocateOptions options;
  options.search_center = position_px<frame::Image>(trial.center_px + Eigen::Vector2d(40, 5));
  options.search_radius = px(30);
  const Detection detection =
      locate(render(trial.scene, trial.camera, random), trial.target, nullptr, options);
  ASSERT_EQ(detection.status, DetectionStatus::Found) << detection.reason;
  EXPECT_NEAR(detection.best->center.position.in_px().x(), trial.center_px.x() + 40, 1);
}

TEST(SlotDetector, FindsASlotThatEndsInThePicture) {
  const Detection detection = locate(picture_of_stadium(150), slot_target());
  ASSERT_EQ(detection.status, DetectionStatus::Found) << detection.reason;
  EXPECT_NEAR(detection.best->size.in_px(), 40, 0.1);
}

TEST(SlotDetector, ADiscIsNoSlot) {
  const Detection detection = locate(picture_of_stadium(40.5), slot_target());
  EXPECT_NE(detection.status, DetectionStatus::Found);
}

TEST(SlotDetector, AWrongWidthIsRejectedWithFigures) {
  Target target = slot_target();
  target.size_px = px(44);
  Random random(1);
  const CellTrial trial = draw_cell_trial(slot_options(), random);
  const Detection detection = locate(render(trial.scene, trial.camera, random), target);
  EXPECT_EQ(detection.status, DetectionStatus::Rejected);
  EXPECT_NE(detection.reason.find("its width is 40"), std::string::npos) << detection.reason;
}

}  // namespace
}  // namespace panelcal::test
