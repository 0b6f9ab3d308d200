// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/frame_patch.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

/// Interpolation of a cubic is exact but for rounding of numbers of about 100.
constexpr double kRounding = 1e-9;

/// Moves the corner of a 640 x 480 picture by 6 px: twice what a machine's lens does.
CameraMapping bent_mapping() {
  return CameraMapping({.scale_mm_per_px = 0.0123,
                        .rotation_rad = 0.3,
                        .axis_px = Eigen::Vector2d(310, 250),
                        .k1_per_px2 = 6 / std::pow(400.0, 3)});
}

TEST(FramePatch, EqualsTheFrameBehindALens) {
  const CameraMapping mapping = bent_mapping();
  const Eigen::Vector2d middle(120.3, 77.8);
  const FitFrame frame(&mapping, Eigen::Vector2d(118, 80));
  const FramePatch patch(frame, middle, 60);
  for (int y = 18; y <= 138; y += 10) {
    const FramePatch::Row row = patch.row(y);
    for (int x = 60; x <= 180; x += 8) {
      const auto at = row.at(x);
      EXPECT_LT((at.place - frame.from_image(Eigen::Vector2d(x, y))).norm(), kRounding);
      EXPECT_LT((at.jacobian - frame.jacobian(Eigen::Vector2d(x, y))).norm(), kRounding);
    }
  }
}

TEST(FramePatch, KnowsItsMiddle) {
  const CameraMapping mapping = bent_mapping();
  const Eigen::Vector2d middle(500.5, 401.25);
  const FitFrame frame(&mapping, middle);
  const FramePatch patch(frame, middle, 25);
  EXPECT_EQ(patch.center_px(), middle);
  // The middle is not one of the places where the frame was asked. X = 0 there.
  constexpr double kMiddleRounding = 1e-9;
  EXPECT_LT((patch.center_place() - frame.from_image(middle)).norm(), kMiddleRounding);
  EXPECT_LT((patch.center_jacobian() - frame.jacobian(middle)).norm(), kMiddleRounding);
}

TEST(FramePatch, IsTheShiftedPictureWithoutAMapping) {
  const FitFrame frame(nullptr, Eigen::Vector2d(30, 40));
  const FramePatch patch(frame, Eigen::Vector2d(33.5, 41), 12);
  const auto at = patch.row(47).at(25);
  EXPECT_LT((at.place - Eigen::Vector2d(-5, 7)).norm(), kRounding);
  EXPECT_LT((at.jacobian - Eigen::Matrix2d::Identity()).norm(), kRounding);
  EXPECT_LT(patch.bend(12), kRounding);
}

/// The largest distance from the tangent plane, on a fine circle.
double bend_by_trying(const FitFrame& frame, const Eigen::Vector2d& middle, double distance_px) {
  double worst = 0;
  for (int i = 0; i < 720; ++i) {
    const double angle = std::numbers::pi * i / 360;
    const Eigen::Vector2d d = distance_px * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d linear = frame.from_image(middle) + frame.jacobian(middle) * d;
    worst = std::max(worst, (frame.from_image(middle + d) - linear).norm());
  }
  return worst;
}

TEST(FramePatch, BendIsTheDistanceFromLinear) {
  const CameraMapping mapping = bent_mapping();
  for (const Eigen::Vector2d& middle :
       {Eigen::Vector2d(310, 250), Eigen::Vector2d(40, 60), Eigen::Vector2d(600, 240)}) {
    const FitFrame frame(&mapping, middle);
    const FramePatch patch(frame, middle, 50);
    const double exact = bend_by_trying(frame, middle, 45);
    // Asked in 8 directions only: at most 22.5 degrees from the worst one.
    EXPECT_GT(patch.bend(45), 0.9 * exact);
    EXPECT_LT(patch.bend(45), exact + kRounding);
  }
}

}  // namespace
}  // namespace panelcal::internal
