// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/step_profile.h"

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

TEST(StepProfile, RecoversAStepWithSlopingSides) {
  const StepProfile truth{.at_px = 0.37,
                          .sigma_px = 1.3,
                          .outside = 40,
                          .outside_slope = -0.4,
                          .inside = 150,
                          .inside_slope = 0.7};
  constexpr double kFirst_px = -9;
  Eigen::ArrayXd levels(20);
  for (Eigen::Index j = 0; j < levels.size(); ++j) {
    levels[j] = truth.level(kFirst_px + static_cast<double>(j));
  }
  const auto step = fit_step(levels, kFirst_px, StepProfile{});
  ASSERT_TRUE(step);
  EXPECT_NEAR(step->at_px, truth.at_px, 0.02);
  EXPECT_NEAR(step->sigma_px, truth.sigma_px, 0.02);
  EXPECT_NEAR(step->outside, truth.outside, 0.3);
  EXPECT_NEAR(step->inside, truth.inside, 0.3);
}

TEST(StepProfile, RecoversAStepBesideAnother) {
  const StepProfile truth{.at_px = 0.37,
                          .sigma_px = 0.9,
                          .outside = 100,
                          .outside_slope = 0,
                          .inside = 160,
                          .inside_slope = 0,
                          .others = {{-2.8, -80}}};
  constexpr double kFirst_px = -7;
  Eigen::ArrayXd levels(15);
  for (Eigen::Index j = 0; j < levels.size(); ++j) {
    levels[j] = truth.level(kFirst_px + static_cast<double>(j));
  }
  EXPECT_NEAR(levels[0], 20, 1);
  StepProfile start;
  start.others = {{-3.5, 0}};
  auto step = fit_step(levels, kFirst_px, start);
  // Two steps take more than one fit, as the passes of a measurement make them.
  for (int pass = 0; pass < 6 && step; ++pass) step = fit_step(levels, kFirst_px, *step);
  ASSERT_TRUE(step);
  EXPECT_NEAR(step->at_px, truth.at_px, 0.02);
  EXPECT_NEAR(step->sigma_px, truth.sigma_px, 0.02);
  EXPECT_NEAR(step->others[0].at_px, -2.8, 0.03);
  EXPECT_NEAR(step->others[0].height, -80, 2);
}

TEST(StepProfile, TooFewLevelsAreNoStep) {
  EXPECT_FALSE(fit_step(Eigen::ArrayXd::LinSpaced(5, 0, 1), -2, StepProfile{}));
}

}  // namespace
}  // namespace panelcal::internal
