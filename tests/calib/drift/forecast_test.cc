// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/forecast.h"

#include <cmath>

#include <gmock/gmock.h>

#include "tests/calib/drift/simulated_nights.h"

namespace panelcal {
namespace {

using test::SimulatedNights;

DriftModel learned(int n_nights, SimulatedNights& nights) {
  DriftModel model = *DriftModel::make(2, {});
  for (int night = 0; night < n_nights; ++night) static_cast<void>(model.add(nights.next()));
  return model;
}

TEST(DriftForecast, SaysUntilWhenToTheMinute) {
  SimulatedNights nights({}, Random(1));
  const DriftModel model = learned(60, nights);
  const ForecastLimits limits = {.tolerance = 0.007, .probability = 0.01, .temperature_c = 21.0};
  const Eigen::VectorXd in_force = model.forecast(*model.last(), 21.0).mean();
  const DrillForecast told = *may_drill(model, in_force, *model.last(), limits);
  ASSERT_EQ(told.answer, DrillAnswer::Until);
  EXPECT_GT(told.until, *model.last());
  const auto chance = [&](std::chrono::sys_seconds t) {
    return chance_beyond(model.forecast(t, 21.0), in_force, limits.tolerance);
  };
  EXPECT_LE(chance(told.until), limits.probability);
  EXPECT_GT(chance(told.until + std::chrono::minutes(1)), limits.probability);
  EXPECT_THAT(words_of(told, limits, "mm"), testing::StartsWith("yes, until 2026-"));
}

TEST(DriftForecast, SaysNoWhereTheMachineHasMovedAway) {
  SimulatedNights nights({}, Random(2));
  const DriftModel model = learned(60, nights);
  const Eigen::VectorXd in_force = nights.truth() + Eigen::Vector2d(0.030, 0);
  const DrillForecast told = *may_drill(model, in_force, *model.last(), {});
  EXPECT_EQ(told.answer, DrillAnswer::No);
  EXPECT_GT(told.chance_now, 0.9);
  EXPECT_THAT(words_of(told, {}, "mm"), testing::StartsWith("no: the calibration in force is "));
}

TEST(DriftForecast, SaysHowFarItDoesNotLook) {
  SimulatedNights nights({}, Random(3));
  const DriftModel model = learned(60, nights);
  const ForecastLimits limits = {.tolerance = 0.1};
  const DrillForecast told = *may_drill(model, nights.truth(), *model.last(), limits);
  EXPECT_EQ(told.answer, DrillAnswer::BeyondHorizon);
  EXPECT_THAT(words_of(told, limits, "mm"), testing::StartsWith("yes, for 30 days and more"));
}

TEST(DriftForecast, SaysThatThereIsNotEnoughHistory) {
  SimulatedNights nights({}, Random(4));
  const DriftModel model = learned(13, nights);
  const DrillForecast told = *may_drill(model, nights.truth(), *model.last(), {});
  EXPECT_EQ(told.answer, DrillAnswer::NotEnoughHistory);
  EXPECT_EQ(words_of(told, {}, "mm"), "no forecast: not enough history");
}

TEST(DriftForecast, RefusesWhatCannotBeAsked) {
  SimulatedNights nights({}, Random(5));
  const DriftModel model = learned(20, nights);
  const Eigen::VectorXd there = nights.truth();
  EXPECT_FALSE(may_drill(model, there, *model.last() - std::chrono::hours(1), {}));
  EXPECT_FALSE(may_drill(model, Eigen::VectorXd::Zero(1), *model.last(), {}));
  EXPECT_FALSE(may_drill(model, std::nan("") * there, *model.last(), {}));
  EXPECT_FALSE(may_drill(model, there, *model.last(), {.tolerance = 0}));
  EXPECT_FALSE(may_drill(model, there, *model.last(), {.probability = 0.7}));
}

TEST(DriftForecast, OfManyAxesEachIsHeldAgainstTheTolerance) {
  // Independent, centred, 1 wide: the chance of each beyond 3 is 0.0027.
  DriftPrediction prediction;
  for (int i = 0; i < 4; ++i) prediction.axes.push_back({{{1, 0, 1}}});
  prediction.correlation = Eigen::MatrixXd::Identity(4, 4);
  const Eigen::VectorXd center = Eigen::VectorXd::Zero(4);
  const double one = 0.0026997960632601866;
  EXPECT_NEAR(chance_beyond(prediction, center, 3), 4 * one, 1e-9);
  // Never more than one, however wide.
  EXPECT_EQ(chance_beyond(prediction, center, 0.1), 1);
}

}  // namespace
}  // namespace panelcal
