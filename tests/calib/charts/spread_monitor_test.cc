// SPDX-License-Identifier: Apache-2.0
#include "calib/charts/spread_monitor.h"

#include <cmath>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

constexpr double kNightsPerFalseAlarm = 500;
constexpr int kMinNights = 5;
constexpr int kDof = 16;

SpreadPoint night_of(int day, Random& random, double sigma) {
  double sum = 0;
  for (int i = 0; i < kDof; ++i) {
    const double e = sigma * random.normal();
    sum += e * e;
  }
  SpreadPoint point;
  point.time = std::chrono::sys_seconds(std::chrono::seconds(86400LL * (20000 + day)));
  point.variance = sum / kDof;
  point.degrees_of_freedom = kDof;
  return point;
}

SpreadMonitor monitor() {
  return *SpreadMonitor::make(kNightsPerFalseAlarm, kMinNights);
}

TEST(SpreadMonitor, AlarmsFalselyAsOftenAsItSaysAtMost) {
  constexpr int kRuns = 400;
  constexpr int kWatched = 120;
  const SpreadMonitor fresh = monitor();
  int n_alarms = 0;
  int n_judged = 0;
  double sum = 0;
  double sum_of_squares = 0;
  for (int i = 0; i < kRuns; ++i) {
    Random random = Random(1).fork(static_cast<std::uint64_t>(i));
    SpreadMonitor watch = fresh;
    for (int day = 0; day < kWatched; ++day) {
      const WatchedSpread seen = *watch.add(night_of(day, random, 0.003));
      n_alarms += seen.is_alarm();
      n_judged += seen.is_judged;
      if (!seen.is_judged) continue;
      sum += seen.score;
      sum_of_squares += seen.score * seen.score;
    }
  }
  // Scores are standard normal but for what alarms leave out of the history.
  EXPECT_NEAR(sum / n_judged, 0, 0.03);
  EXPECT_NEAR(sum_of_squares / n_judged, 1, 0.03);
  const double expected = n_judged / kNightsPerFalseAlarm;
  EXPECT_LE(n_alarms, expected + 4 * std::sqrt(expected));
  EXPECT_GE(n_alarms, 0.4 * expected);  // it does look
}

TEST(SpreadMonitor, FlagsADirtyLensAndAWornDrill) {
  constexpr int kRuns = 200;
  const SpreadMonitor fresh = monitor();
  int n_at_once = 0;
  int n_in_time = 0;
  for (int i = 0; i < kRuns; ++i) {
    Random random = Random(2).fork(static_cast<std::uint64_t>(i));
    SpreadMonitor dirty = fresh;
    SpreadMonitor worn = fresh;
    for (int day = 0; day < 40; ++day) {
      static_cast<void>(dirty.add(night_of(day, random, 1)));
      static_cast<void>(worn.add(night_of(day, random, 1)));
    }
    n_at_once += dirty.add(night_of(40, random, 2.5))->is_alarm();
    // Grows by 5 % a day; flagged before it has doubled, which takes 20.
    for (int day = 40; day < 60; ++day) {
      if (!worn.add(night_of(day, random, 1 + 0.05 * (day - 39)))->is_alarm()) continue;
      ++n_in_time;
      break;
    }
  }
  EXPECT_GE(n_at_once, 0.99 * kRuns);
  EXPECT_GE(n_in_time, 0.99 * kRuns);
}

TEST(SpreadMonitor, ForgetsAtAFreshStart) {
  SpreadMonitor watch = monitor();
  Random random(3);
  for (int day = 0; day < 40; ++day) static_cast<void>(watch.add(night_of(day, random, 1)));
  SpreadPoint cleaned = night_of(40, random, 5);
  cleaned.is_fresh_start = true;
  EXPECT_FALSE(watch.add(cleaned)->is_judged);
  for (int day = 41; day < 60; ++day) EXPECT_FALSE(watch.add(night_of(day, random, 5))->is_alarm());
}

TEST(SpreadMonitor, TakesNothingForANight) {
  SpreadMonitor watch = monitor();
  Random random(4);
  ASSERT_TRUE(watch.add(night_of(1, random, 1)));
  EXPECT_FALSE(watch.add(night_of(1, random, 1)));
  SpreadPoint point = night_of(2, random, 1);
  point.variance = std::nan("");
  EXPECT_FALSE(watch.add(point));
  point.variance = -1;
  EXPECT_FALSE(watch.add(point));
  point.variance = 1;
  point.degrees_of_freedom = 0;
  EXPECT_FALSE(watch.add(point));
  EXPECT_FALSE(SpreadMonitor::make(1, 5));
  EXPECT_FALSE(SpreadMonitor::make(1000, 0));
  // Exact nights, variance 0, are no alarm and no crash.
  point.degrees_of_freedom = 4;
  point.variance = 0;
  EXPECT_FALSE(watch.add(point)->is_alarm());
}

}  // namespace
}  // namespace panelcal
