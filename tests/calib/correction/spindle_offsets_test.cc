// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/spindle_offsets.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

SpindleCameraOffset offset(double x_mm, double y_mm, double variance_mm2 = 1e-6) {
  return {displacement_mm<frame::Machine>(x_mm, y_mm), variance_mm2 * Eigen::Matrix2d::Identity()};
}

/// Two spindles at two stations.
SpindleOffsets four() {
  SpindleOffsets offsets;
  EXPECT_TRUE(offsets.set({1, 1}, offset(80, -3)));
  EXPECT_TRUE(offsets.set({2, 1}, offset(20, -3.5, 3e-6)));
  EXPECT_TRUE(offsets.set({1, 2}, offset(80.1, -3.1)));
  EXPECT_TRUE(offsets.set({2, 2}, offset(20.1, -3.6)));
  return offsets;
}

TEST(SpindleOffsets, AreFoundForTheirSpindleAndStationOnly) {
  const SpindleOffsets offsets = four();
  ASSERT_NE(offsets.find({2, 1}), nullptr);
  EXPECT_EQ(offsets.find({2, 1})->offset, displacement_mm<frame::Machine>(20, -3.5));
  EXPECT_EQ(offsets.find({3, 1}), nullptr);
}

TEST(SpindleOffsets, RefuseWhatNoMachineHas) {
  SpindleOffsets offsets;
  EXPECT_FALSE(offsets.set({0, 1}, offset(1, 1)));
  EXPECT_FALSE(offsets.set({13, 1}, offset(1, 1)));
  EXPECT_FALSE(offsets.set({1, 3}, offset(1, 1)));
  EXPECT_FALSE(offsets.set({1, 1}, offset(std::nan(""), 1)));
  EXPECT_FALSE(offsets.set({1, 1}, offset(1, 1, -1)));
  EXPECT_TRUE(offsets.empty());
}

TEST(SpindleOffsets, TellWhereOneSpindleIsFromAnother) {
  // The camera at (100, 50): spindle 1 is then at (20, 53), spindle 2 at (80, 53.5).
  const auto distance = four().between(1, 2, 1);
  ASSERT_TRUE(distance);
  EXPECT_THAT(distance->distance,
              test::IsNearPosition(displacement_mm<frame::Machine>(60, 0.5), um(1e-6)));
  EXPECT_NEAR(distance->cov_mm2(0, 0), 4e-6, 1e-18);
  EXPECT_FALSE(four().between(1, 3, 1));
  EXPECT_EQ(four().between(1, 1, 1)->cov_mm2, Eigen::Matrix2d::Zero());
}

TEST(SpindleOffsets, ACorrectedOffsetSeesTheHoleWhereItWasDrilled) {
  // A hole drilled at p and measured through the old offset.
  const auto p = position_mm<frame::Machine>(200, 100);
  const SpindleCameraOffset truth = offset(80.02, -3.01);
  SpindleOffsets offsets = four();
  const auto spindle = offsets.find({1, 1})->spindle_to_see(p);
  const auto seen = position_mm<frame::Optical>((p - truth.optical_axis(spindle)).in_mm());
  const auto measured = machine_from_optical(offsets.find({1, 1})->optical_axis(spindle), seen);
  const Eigen::Matrix2d cov = 9e-6 * Eigen::Matrix2d::Identity();
  EXPECT_EQ(offsets.correct({OffsetOrder::Of::Station, 1}, measured - p, cov), 2);
  EXPECT_THAT(offsets.find({1, 1})->offset, test::IsNearPosition(truth.offset, um(1e-6)));
  EXPECT_EQ(offsets.find({1, 1})->cov_mm2, cov);
  EXPECT_EQ(offsets.find({1, 2})->offset, displacement_mm<frame::Machine>(80.1, -3.1));
}

TEST(SpindleOffsets, OrdersMoveWhatTheyName) {
  const auto deviation = displacement_mm<frame::Machine>(0.01, 0);
  const Eigen::Matrix2d cov = 1e-6 * Eigen::Matrix2d::Identity();
  const auto moved = [&](OffsetOrder order) {
    SpindleOffsets offsets = four();
    offsets.correct(order, deviation, cov);
    std::string names;
    for (const auto& [at, now] : offsets.all()) {
      if (now.offset == four().find(at)->offset) continue;
      names += std::to_string(at.spindle) + "@" + std::to_string(at.station) + " ";
    }
    return names;
  };
  EXPECT_EQ(moved({OffsetOrder::Of::Station, 2}), "1@2 2@2 ");
  EXPECT_EQ(moved({OffsetOrder::Of::Spindle, 1}), "1@1 1@2 ");
  EXPECT_EQ(moved({OffsetOrder::Of::SpindleToSpindle, 1}), "2@1 2@2 ");
  EXPECT_EQ(moved({OffsetOrder::Of::Spindle, 7}), "");
}

TEST(SpindleOffsets, ADeviationThatIsNoneChangesNothing) {
  SpindleOffsets offsets = four();
  const Eigen::Matrix2d cov = 1e-6 * Eigen::Matrix2d::Identity();
  const auto nan = displacement_mm<frame::Machine>(std::nan(""), 0);
  EXPECT_EQ(offsets.correct({}, nan, cov), 0);
  EXPECT_EQ(offsets.correct({}, displacement_mm<frame::Machine>(0, 0), -cov), 0);
  EXPECT_EQ(offsets.find({1, 1})->offset, displacement_mm<frame::Machine>(80, -3));
}

}  // namespace
}  // namespace panelcal
