// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/drift/monitor.h"
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/calib/drift/simulated_nights.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using test::SimulatedMachine;
using test::SimulatedNights;

DriftPoint point(int day, double value, double sigma) {
  DriftPoint p;
  p.time = std::chrono::sys_seconds(std::chrono::seconds(86400LL * (20000 + day)));
  p.value = Eigen::VectorXd::Constant(1, value);
  p.cov = Eigen::MatrixXd::Constant(1, 1, sigma * sigma);
  return p;
}

/// The mean of the level after some nights by generalised least squares: the covariance of values
/// under a random walk with noise is min(s, t) q + r, plus the same unknown for all.
TEST(DriftModel, FiltersAsLeastSquaresDoes) {
  DriftOptions options;
  // Narrow priors, so that all filters are nearly the same.
  options.priors = {
      .drift = 0.4, .drift_factor = 1.0501, .repeatability = 0.3, .repeatability_factor = 1.0501};
  DriftModel model = *DriftModel::make(1, options);
  const std::vector<double> values = {3.0, 3.9, 2.8, 3.3, 4.6};
  constexpr double kSigma = 0.5;
  for (int t = 0; t < 5; ++t) {
    DriftPoint p = point(t, values[static_cast<std::size_t>(t)], kSigma);
    p.temperature_c = 20;
    ASSERT_TRUE(model.add(p));
  }
  // Level at the last night is x5 = x1 + steps. Unknown x1, flat.
  Eigen::MatrixXd cov(5, 5);
  Eigen::VectorXd with_last(5);
  for (int s = 0; s < 5; ++s) {
    for (int t = 0; t < 5; ++t) {
      cov(s, t) = 0.16 * std::min(s, t) + (s == t ? kSigma * kSigma + 0.09 : 0);
    }
    with_last(s) = 0.16 * s;
  }
  const Eigen::MatrixXd inverse = cov.inverse();
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(5);
  const Eigen::VectorXd y = Eigen::Map<const Eigen::VectorXd>(values.data(), 5);
  const double start = ones.dot(inverse * y) / ones.dot(inverse * ones);
  const double last = start + with_last.dot(inverse * (y - start * ones));
  const double leverage = 1 - with_last.dot(inverse * ones);
  const double variance = 0.16 * 4 - with_last.dot(inverse * with_last) +
                          leverage * leverage / ones.dot(inverse * ones);
  const DriftPrediction seen = model.forecast(*model.last(), 20.0);
  // A grid of one step either way is symmetric, and its weights hardly move.
  EXPECT_NEAR(seen.axes[0].mean(), last, 0.02);
  EXPECT_NEAR(std::sqrt(seen.axes[0].variance()), std::sqrt(variance), 0.03);
}

TEST(DriftModel, FindsWhatTemperatureDoes) {
  SimulatedNights nights({.x_per_kelvin = 0.0015, .temperature_sigma = 2}, Random(5));
  DriftModel model = *DriftModel::make(2, {});
  for (int night = 0; night < 120; ++night) ASSERT_TRUE(model.add(nights.next()));
  const Eigen::Vector2d of_ten_kelvin =
      model.forecast(*model.last(), 30).mean() - model.forecast(*model.last(), 20).mean();
  // A night's 1.3 um in all, over 2 K and the root of 120 nights, is 0.06 um a kelvin: four of it.
  constexpr double kFourSigmas_mm = 0.0024;
  EXPECT_NEAR(of_ten_kelvin.x(), 0.015, kFourSigmas_mm);
  EXPECT_NEAR(of_ten_kelvin.y(), 0, kFourSigmas_mm);
}

TEST(DriftModel, ForetellsAsWellAsItSays) {
  constexpr int kRuns = 400;
  constexpr int kNights = 20;
  double chi_square = 0;
  for (int i = 0; i < kRuns; ++i) {
    SimulatedNights nights({}, Random(7).fork(static_cast<std::uint64_t>(i)));
    DriftModel model = *DriftModel::make(2, {});
    for (int night = 0; night < kNights; ++night) ASSERT_TRUE(model.add(nights.next()));
    DriftPoint ahead;
    for (int night = 0; night < 5; ++night) ahead = nights.next();
    const DriftPrediction told = model.forecast(ahead.time, ahead.temperature_c);
    const Eigen::Vector2d error = nights.truth() - told.mean();
    chi_square += error.dot(told.cov().inverse() * error);
  }
  // Sigmas are learned from 20 nights, so the forecast is of this mean but not exactly chi square.
  EXPECT_NEAR(chi_square / (2 * kRuns), 1, 0.2);
}

TEST(DriftModel, AFreshStartForgetsTheLevelAndKeepsTheRest) {
  SimulatedNights nights({}, Random(8));
  DriftModel model = *DriftModel::make(2, {});
  for (int night = 0; night < 60; ++night) ASSERT_TRUE(model.add(nights.next()));
  // In ten days the variance grows by ten times that of a day, in ten kelvin the value by ten times
  // that of one.
  const auto growth = [&] {
    const auto later = *model.last() + std::chrono::days(10);
    return model.forecast(later, 20).axes[0].variance() -
           model.forecast(*model.last(), 20).axes[0].variance();
  };
  const auto of_ten_kelvin = [&] {
    return model.forecast(*model.last(), 30).mean()(0) -
           model.forecast(*model.last(), 20).mean()(0);
  };
  const double growth_before = growth();
  const double of_ten_kelvin_before = of_ten_kelvin();
  DriftPoint moved = nights.next(Eigen::Vector2d(3, -2));
  moved.is_fresh_start = true;
  ASSERT_TRUE(model.add(moved));
  // The first night of a level weighs the filters a little.
  EXPECT_NEAR(growth() / growth_before, 1, 0.2);
  EXPECT_NEAR(of_ten_kelvin(), of_ten_kelvin_before, 1e-5);
  const DriftPrediction told = model.forecast(moved.time, moved.temperature_c);
  EXPECT_NEAR(told.mean().x(), nights.truth().x(), 0.006);
  // As unsure as one night: stated and repeatability together are 1.2 um.
  EXPECT_NEAR(std::sqrt(told.cov()(0, 0)), 0.0012, 0.0005);
}

TEST(DriftModel, LearnsNothingFromWhatWasLeftOut) {
  DriftModel model = *DriftModel::make(1, {});
  ASSERT_TRUE(model.add(point(1, 5, 0.001)));
  DriftPoint refused = point(2, 9, 0.001);
  refused.is_left_out = true;
  ASSERT_TRUE(model.add(refused));
  EXPECT_EQ(model.n_nights(), 1);
  EXPECT_NEAR(model.forecast(refused.time, 20.0).mean()(0), 5, 1e-6);
}

TEST(DriftModel, RefusesWhatIsNoNight) {
  DriftModel model = *DriftModel::make(1, {});
  ASSERT_TRUE(model.add(point(1, 5, 0.001)));
  EXPECT_FALSE(model.add(point(1, 5, 0.001)));
  EXPECT_FALSE(model.add(point(2, std::nan(""), 0.001)));
  EXPECT_FALSE(model.add(point(2, 1e200, 0.001)));
  DriftPoint p = point(3, 5, 0.001);
  p.cov(0, 0) = -1;
  EXPECT_FALSE(model.add(p));
  p.cov.resize(2, 2);
  EXPECT_FALSE(model.add(p));
  p = point(4, 5, 0.001);
  p.temperature_c = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(model.add(p));
  EXPECT_EQ(model.n_nights(), 1);
  EXPECT_FALSE(DriftModel::make(0, {}));
  DriftOptions options;
  options.priors.drift = 0;
  EXPECT_FALSE(DriftModel::make(1, options));
}

TEST(DriftModel, RefusesCorrelationsThatDoNotFitTogether) {
  DriftModel model = *DriftModel::make(3, {});
  DriftPoint p = point(1, 5, 0.001);
  p.value = Eigen::Vector3d(5, 5, 5);
  // Each pair may be correlated by -0.6, but not all three at once: the sum's variance is below 0.
  p.cov = Eigen::Matrix3d::Constant(-0.6);
  p.cov.diagonal().setOnes();
  EXPECT_FALSE(model.add(p));
  p.cov = Eigen::Matrix3d::Constant(0.6);
  p.cov.diagonal().setOnes();
  EXPECT_TRUE(model.add(p));
}

TEST(DriftModel, TakesExactValuesAndLongGaps) {
  DriftModel model = *DriftModel::make(1, {});
  for (int night = 0; night < 30; ++night) ASSERT_TRUE(model.add(point(1 + 300 * night, 5, 0)));
  const DriftPrediction told = model.predict(point(9000, 5, 0));
  EXPECT_NEAR(told.mean()(0), 5, 1e-9);
  EXPECT_GT(told.cov()(0, 0), 0);
}

TEST(DriftMonitor, SaysNothingBeforeThereIsHistory) {
  SimulatedNights nights({}, Random(9));
  DriftMonitor monitor = *DriftMonitor::make(2, {}, {});
  for (int night = 0; night < 14; ++night) {
    const WatchedNight seen = *monitor.add(nights.next());
    EXPECT_FALSE(seen.is_judged);
    EXPECT_TRUE(seen.alarms.empty());
  }
  EXPECT_TRUE(monitor.add(nights.next())->is_judged);
}

TEST(DriftMonitor, JudgesByTheNewLevelAfterAStep) {
  SimulatedNights nights({}, Random(10));
  DriftMonitor monitor = *DriftMonitor::make(2, {}, {});
  for (int night = 0; night < 40; ++night) ASSERT_TRUE(monitor.add(nights.next())->alarms.empty());
  const Eigen::Vector2d moved(0.030, 0);
  const WatchedNight step = *monitor.add(nights.next(moved));
  ASSERT_FALSE(step.alarms.empty());
  EXPECT_EQ(step.alarms[0].chart, DriftChart::Night);
  EXPECT_EQ(words_of(step.alarms[0], {"x", "y"}, "mm").substr(0, 7), "a step:");
  for (int night = 0; night < 10; ++night) {
    EXPECT_TRUE(monitor.add(nights.next(moved))->alarms.empty()) << night;
  }
}

TEST(DriftMonitor, SaysHowFarItHasMovedHoweverSlowly) {
  SimulatedNights nights({.drift = 0.0001, .x_per_kelvin = 0}, Random(11));
  const std::vector<std::string> names = {"x", "y"};
  DriftMonitor monitor = *DriftMonitor::make(2, {}, {});
  double said_mm = 0;
  for (int night = 0; night < 200 && said_mm == 0; ++night) {
    const double moved_mm = 0.00005 * night;
    const WatchedNight seen = *monitor.add(nights.next(Eigen::Vector2d(0, moved_mm)));
    for (const DriftAlarm& alarm : seen.alarms) {
      if (alarm.chart != DriftChart::Moved) continue;
      said_mm = moved_mm;
      EXPECT_EQ(words_of(alarm, names, "mm").substr(0, 18), "it has moved by 6.");
    }
  }
  // 6 um after the first judged night, give or take three sigmas of the random walk of so many
  // nights.
  EXPECT_NEAR(said_mm, 0.0067, 0.0035);
  EXPECT_EQ(words_of(DriftAlarm{DriftChart::Sum, 12.3, 12.1, 1}, names, "mm").substr(0, 19),
            "a slow drift of y: ");
}

TEST(DriftMonitor, DatesAStepByItsNight) {
  SimulatedNights nights({}, Random(12));
  DriftMonitor monitor = *DriftMonitor::make(2, {}, {});
  for (int night = 0; night < 40; ++night) ASSERT_TRUE(monitor.add(nights.next())->alarms.empty());
  const DriftPoint point = nights.next(Eigen::Vector2d(0.030, 0));
  const WatchedNight step = *monitor.add(point);
  ASSERT_TRUE(step.is_step());
  EXPECT_EQ(step.since, point.time);
  // The new level is one night's, good to 1.2 um.
  EXPECT_NEAR(step.moved(0), 0.030, 0.005);
  EXPECT_NEAR(step.moved(1), 0, 0.005);
}

/// The median error, in days, of the date that the first alarm gives a ramp that began after 60
/// nights; over the runs.
double median_error_of_dates(const WatchOptions& watch, double mm_per_day) {
  constexpr int kRuns = 12;
  constexpr int kOnset = 60;
  constexpr double kDay_s = 86400;
  std::vector<double> errors;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    SimulatedNights nights({.drift = 0.0001, .x_per_kelvin = 0}, Random(100 + seed));
    DriftMonitor monitor = *DriftMonitor::make(2, {}, watch);
    std::chrono::sys_seconds onset;
    for (int night = 0; night < 3 * kOnset; ++night) {
      const double moved_mm = mm_per_day * std::max(0, night - kOnset + 1);
      const WatchedNight seen = *monitor.add(nights.next(Eigen::Vector2d(0, moved_mm)));
      if (night == kOnset) onset = seen.time;
      if (night < kOnset || seen.alarms.empty()) continue;
      EXPECT_GT(seen.moved(1), 0);
      errors.push_back(std::abs(static_cast<double>((seen.since - onset).count())) / kDay_s);
      break;
    }
  }
  EXPECT_EQ(errors.size(), kRuns);
  std::ranges::sort(errors);
  return errors[errors.size() / 2];
}

TEST(DriftMonitor, DatesASlowDriftByItsSums) {
  // Simulated years (tests/bench/README.md): 5 nights at 0.3 um a day, 3 at 1 um.
  EXPECT_LE(median_error_of_dates({.moved = std::nullopt}, 0.0005), 8);
  // Most of these alarms say that it has moved, from a level that is 46 nights older than the ramp.
  EXPECT_LE(median_error_of_dates({}, 0.0002), 12);
}

TEST(DriftMonitor, SaysWhatMovedSinceWhen) {
  WatchedNight night;
  night.time = std::chrono::sys_seconds(std::chrono::seconds(1'790'000'000));  // 2026-09-21
  night.since = night.time - std::chrono::days(9);
  night.moved = Eigen::Vector3d(0.0062, -0.0031, 0.0004);
  night.alarms.push_back({DriftChart::Sum, 12.3, 12.1, 1});
  EXPECT_EQ(words_of(night, {"x", "y", "z"}, "mm"),
            "x moved by +6.2 um, y by -3.1 um since about the night of 2026-09-12, as the alarm in "
            "the night of 2026-09-21 says");
  night.alarms.front().chart = DriftChart::Night;
  EXPECT_EQ(words_of(night, {"x", "y", "z"}, "mm"),
            "x moved by +6.2 um, y by -3.1 um in the night of 2026-09-21");
}

}  // namespace
}  // namespace panelcal
