// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "calib/base/statistics/random.h"
#include "calib/charts/cusum.h"
#include "calib/charts/ewma.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

constexpr double kNights = 1000;

TEST(Charts, AnAverageSeesTheSameInEveryDirection) {
  EwmaChart along(2, 0.2, kNights);
  EwmaChart across(2, 0.2, kNights);
  for (int night = 0; night < 3; ++night) {
    along.add(Eigen::Vector2d(1, 0));
    across.add(Eigen::Vector2d(-0.6, 0.8));
  }
  // 1 - 0.8^3 of the shift has come in; sigma of the average is sqrt(0.2 / 1.8) = 1/3.
  EXPECT_NEAR(along.statistic(), 3 * (1 - 0.512), 1e-12);
  EXPECT_NEAR(across.statistic(), along.statistic(), 1e-12);
}

TEST(Charts, SumsCountWhatIsAboveTheAllowance) {
  CusumChart chart(Shift::Both, 0.25, kNights);
  for (const double u : {1.0, -0.5, 2.0}) EXPECT_FALSE(chart.add(u));
  EXPECT_NEAR(chart.statistic(), 1.75, 1e-12);  // 0.75, then nothing left, then 1.75
  int n_more = 0;
  while (!chart.add(-1)) ++n_more;
  // Downwards: -0.5 gave 0.25 and 2 took it; then 0.75 a night up to the limit.
  EXPECT_EQ(n_more, static_cast<int>(chart.limit() / 0.75));
  chart.restart();
  EXPECT_EQ(chart.statistic(), 0);
}

TEST(Charts, SumsKnowForHowManyNightsTheyHaveGrown) {
  CusumChart chart(Shift::Both, 0.25, kNights);
  EXPECT_EQ(chart.n_nights(), 0);
  for (const double u : {1.0, -2.0, 0.5, 3.0, -0.5, 1.0}) chart.add(u);
  // The second night brought the sum to nought, and the fifth did not.
  EXPECT_EQ(chart.n_nights(), 4);
  chart.restart();
  chart.add(-1);
  EXPECT_EQ(chart.n_nights(), 1);
}

TEST(Charts, LookOnlyUpIfAskedTo) {
  CusumChart chart(Shift::Up, 0.25, kNights);
  for (int night = 0; night < 100; ++night) EXPECT_FALSE(chart.add(-3));
  EXPECT_LT(chart.limit(), CusumChart(Shift::Both, 0.25, kNights).limit());
}

TEST(Charts, AlarmAtWhatIsNotANumber) {
  EXPECT_TRUE(EwmaChart(1, 0.2, kNights).add(Eigen::VectorXd::Constant(1, std::nan(""))));
  EXPECT_TRUE(CusumChart(Shift::Up, 0.25, kNights).add(std::nan("")));
}

}  // namespace
}  // namespace panelcal
