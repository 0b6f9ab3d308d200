// SPDX-License-Identifier: Apache-2.0
#include "surface/control/memory.h"

#include <cmath>
#include <initializer_list>
#include <limits>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using testing::AllOf;
using ::testing::HasSubstr;
using Heights = std::vector<HeightEstimate>;

/// A few roundings of heights of some mm.
constexpr double kRounding_mm = 1e-14;

HeightEstimate estimate(double height_mm, double sigma_mm = 0.002) {
  return {mm(height_mm), mm(sigma_mm)};
}

SurfaceMemory filled(std::initializer_list<HeightEstimate> values) {
  SurfaceMemory memory;
  for (const HeightEstimate& value : values) EXPECT_TRUE(memory.add({value}));
  return memory;
}

HeightEstimate average(std::initializer_list<HeightEstimate> values, AverageKind kind) {
  SurfaceMemory memory = filled(values);
  const auto average = memory.take_average(kind);
  if (!average) {
    ADD_FAILURE() << average.error();
    return {};
  }
  EXPECT_EQ(average->size(), 1u);
  return average->front();
}

double average_mm(std::initializer_list<double> heights_mm, AverageKind kind) {
  SurfaceMemory memory;
  for (const double height_mm : heights_mm) EXPECT_TRUE(memory.add({estimate(height_mm)}));
  const auto average = memory.take_average(kind);
  if (!average) {
    ADD_FAILURE() << average.error();
    return 0;
  }
  return average->front().height.in_mm();
}

TEST(SurfaceMemory, GivesBackWhatWasStored) {
  SurfaceMemory memory;
  ASSERT_TRUE(memory.store(1, {estimate(1.6), estimate(1.7, 0.003)}));
  ASSERT_TRUE(memory.store(0, {estimate(1.5), estimate(1.4)}));
  const auto loaded = memory.load(1);
  ASSERT_TRUE(loaded) << loaded.error();
  ASSERT_EQ(loaded->size(), 2u);
  EXPECT_EQ((*loaded)[0].height, mm(1.6));
  EXPECT_EQ((*loaded)[1].height, mm(1.7));
  EXPECT_EQ((*loaded)[1].sigma, mm(0.003));
  EXPECT_EQ(memory.load(0)->front().height, mm(1.5));
}

TEST(SurfaceMemory, TheLastValueStoredRules) {
  SurfaceMemory memory;
  ASSERT_TRUE(memory.store(7, {estimate(1.6)}));
  ASSERT_TRUE(memory.store(7, {estimate(1.8)}));
  EXPECT_EQ(memory.load(7)->front().height, mm(1.8));
}

TEST(SurfaceMemory, G72ClearsTheValuesAndNotTheAveragingArea) {
  SurfaceMemory memory = filled({estimate(1.6)});
  ASSERT_TRUE(memory.store(1, {estimate(1.6)}));
  memory.clear();
  ASSERT_FALSE(memory.load(1));
  EXPECT_THAT(memory.load(1).error(), HasSubstr("L1 "));
  EXPECT_EQ(memory.n_to_average(), 1u);
}

TEST(SurfaceMemory, AProgramBeginsWithNothing) {
  SurfaceMemory memory = filled({estimate(1.6)});
  ASSERT_TRUE(memory.store(1, {estimate(1.6)}));
  memory.reset();
  EXPECT_FALSE(memory.load(1));
  EXPECT_EQ(memory.n_to_average(), 0u);
  EXPECT_TRUE(memory.store(1, {estimate(1), estimate(2)})) << "the Z axes are forgotten as well";
}

TEST(SurfaceMemory, RefusesAnotherNumberOfZAxes) {
  SurfaceMemory memory;
  ASSERT_TRUE(memory.add({estimate(1), estimate(2)}));
  const auto stored = memory.store(1, {estimate(1)});
  ASSERT_FALSE(stored);
  EXPECT_THAT(stored.error(), AllOf(HasSubstr("1 Z axes"), HasSubstr("2")));
  EXPECT_FALSE(memory.add({estimate(1), estimate(2), estimate(3)}));
  EXPECT_FALSE(memory.add({}));
  EXPECT_EQ(memory.n_to_average(), 1u);
  EXPECT_FALSE(memory.load(1));
}

TEST(SurfaceMemory, RefusesNumbersThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  SurfaceMemory memory;
  for (const HeightEstimate& bad :
       {estimate(nan), estimate(inf), estimate(1, nan), estimate(1, inf), estimate(1, -1e-9)}) {
    EXPECT_FALSE(memory.store(1, {bad}));
    EXPECT_FALSE(memory.add({estimate(1), bad}));
  }
  EXPECT_TRUE(memory.store(1, {estimate(1, 0)}));
  const auto negative = memory.store(-1, {estimate(1)});
  ASSERT_FALSE(negative);
  EXPECT_THAT(negative.error(), HasSubstr("L-1"));
}

TEST(SurfaceMemory, TheAveragingAreaTakesAHundredValues) {
  SurfaceMemory memory;
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(memory.add({estimate(i)})) << i;
  const auto full = memory.add({estimate(100)});
  ASSERT_FALSE(full);
  EXPECT_THAT(full.error(), HasSubstr("100 "));
  // 0 + 1 + ... + 99 over 100: the refused value has no part in it.
  EXPECT_EQ(memory.take_average(AverageKind::Mean)->front().height, mm(49.5));
  EXPECT_TRUE(memory.add({estimate(1)}));
}

// SIEB & MEYER CNC 8x.00, G74: the four scans of the first example, and its four ways to average.
TEST(SurfaceMemory, ManualG74AveragesFourScans) {
  EXPECT_NEAR(average_mm({1.62, 1.58, 1.70, 1.60}, AverageKind::Mean), 1.625, kRounding_mm);
  EXPECT_NEAR(average_mm({1.62, 1.58, 1.70, 1.60}, AverageKind::Median), 1.61, kRounding_mm);
  EXPECT_NEAR(average_mm({1.62, 1.58, 1.70, 1.60}, AverageKind::MidRange), 1.64, kRounding_mm);
  EXPECT_NEAR(average_mm({1.62, 1.58, 1.70, 1.60}, AverageKind::TrimmedMean), 1.61, kRounding_mm);
}

TEST(SurfaceMemory, MedianOfAnOddNumberIsTheMiddleValue) {
  EXPECT_EQ(average_mm({5, -1, 3}, AverageKind::Median), 3);
  EXPECT_EQ(average_mm({5, 9, -1, 3, 3}, AverageKind::Median), 3);
  EXPECT_EQ(average_mm({5, 9, -1, 3, 4}, AverageKind::TrimmedMean), 4);
  EXPECT_EQ(average_mm({5, 9, -1, 3, 4}, AverageKind::MidRange), 4);
}

TEST(SurfaceMemory, OneValueIsItsOwnAverage) {
  for (const auto kind : {AverageKind::Mean, AverageKind::Median, AverageKind::MidRange}) {
    const HeightEstimate one = average({estimate(1.5, 0.25)}, kind);
    EXPECT_EQ(one.height, mm(1.5));
    EXPECT_EQ(one.sigma, mm(0.25));
  }
}

TEST(SurfaceMemory, SigmaComesFromTheValuesThatEnter) {
  const auto values = {estimate(1, 0.3), estimate(2, 0.4), estimate(5, 1.2), estimate(4, 0.5)};
  // sqrt(0.09 + 0.16 + 1.44 + 0.25) / 4; then 2 and 4; 1 and 5; 2 and 4 again.
  EXPECT_NEAR(average(values, AverageKind::Mean).sigma.in_mm(), std::sqrt(1.94) / 4, kRounding_mm);
  EXPECT_NEAR(
      average(values, AverageKind::Median).sigma.in_mm(), std::sqrt(0.41) / 2, kRounding_mm);
  EXPECT_NEAR(
      average(values, AverageKind::MidRange).sigma.in_mm(), std::sqrt(1.53) / 2, kRounding_mm);
  EXPECT_NEAR(
      average(values, AverageKind::TrimmedMean).sigma.in_mm(), std::sqrt(0.41) / 2, kRounding_mm);
}

TEST(SurfaceMemory, EveryZAxisIsAveragedForItself) {
  SurfaceMemory memory;
  // The second axis has its middle value in another scan than the first.
  ASSERT_TRUE(memory.add({estimate(1), estimate(30)}));
  ASSERT_TRUE(memory.add({estimate(2), estimate(10)}));
  ASSERT_TRUE(memory.add({estimate(3), estimate(20)}));
  const auto median = memory.take_average(AverageKind::Median);
  ASSERT_TRUE(median) << median.error();
  ASSERT_EQ(median->size(), 2u);
  EXPECT_EQ((*median)[0].height, mm(2));
  EXPECT_EQ((*median)[1].height, mm(20));
  EXPECT_EQ(memory.n_to_average(), 0u);
}

TEST(SurfaceMemory, RefusesToAverageNothing) {
  SurfaceMemory memory;
  const auto nothing = memory.take_average(AverageKind::Mean);
  ASSERT_FALSE(nothing);
  EXPECT_THAT(nothing.error(), AllOf(HasSubstr("0 "), HasSubstr("1 "), HasSubstr("G73")));
}

TEST(SurfaceMemory, ATrimmedMeanNeedsThreeValues) {
  SurfaceMemory memory = filled({estimate(1), estimate(2)});
  const auto refused = memory.take_average(AverageKind::TrimmedMean);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error(), AllOf(HasSubstr("2 "), HasSubstr("3 "), HasSubstr("SPAV,T")));
  EXPECT_EQ(memory.n_to_average(), 2u) << "a call that fails changes nothing";
  ASSERT_TRUE(memory.add({estimate(7)}));
  EXPECT_EQ(memory.take_average(AverageKind::TrimmedMean)->front().height, mm(2));
}

/// Mean chi square of averages of `n` readings of one and the same height.
double chi_square_of(AverageKind kind, int n_trials) {
  Random random(401);
  double sum = 0;
  for (int trial = 0; trial < n_trials; ++trial) {
    SurfaceMemory memory;
    for (int i = 0; i < 5; ++i) {
      EXPECT_TRUE(memory.add({estimate(1.6 + 0.002 * random.normal(), 0.002)}));
    }
    const HeightEstimate average = memory.take_average(kind)->front();
    const double error = (average.height.in_mm() - 1.6) / average.sigma.in_mm();
    sum += error * error;
  }
  return sum;
}

TEST(SurfaceMemory, TheMeanErrsAsItSays) {
  constexpr int kTrials = 4000;
  EXPECT_TRUE(test::chi_square_agrees(chi_square_of(AverageKind::Mean, kTrials), kTrials));
}

TEST(SurfaceMemory, OtherAveragesOfOneHeightErrNoMoreThanTheySay) {
  constexpr int kTrials = 4000;
  // Normal order statistics of five: the variances of median and of mid-range are 0.287 and 0.261
  // (Sarhan and Greenberg 1962), propagated are 1 and 1/2; the trimmed mean lies between.
  for (const auto kind : {AverageKind::Median, AverageKind::MidRange, AverageKind::TrimmedMean}) {
    EXPECT_LT(chi_square_of(kind, kTrials) / kTrials, 0.9);
  }
  EXPECT_NEAR(chi_square_of(AverageKind::Median, kTrials) / kTrials, 0.287, 0.03);
  EXPECT_NEAR(chi_square_of(AverageKind::MidRange, kTrials) / kTrials, 0.261 / 0.5, 0.05);
}

}  // namespace
}  // namespace panelcal
