// SPDX-License-Identifier: Apache-2.0
// Rates and detections over simulated runs of 120 nights.
#include <cmath>
#include <iostream>

#include "calib/drift/monitor.h"
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/calib/drift/simulated_nights.h"

namespace panelcal {
namespace {

using test::SimulatedMachine;
using test::SimulatedNights;

constexpr int kNights = 120;
constexpr double kNightsPerFalseAlarm = 1000;

DriftMonitor monitor(std::optional<double> moved = std::nullopt) {
  const WatchOptions watch = {.nights_per_false_alarm = kNightsPerFalseAlarm, .moved = moved};
  return *DriftMonitor::make(2, {}, watch);
}

struct Rate {
  int n_alarms = 0;
  int n_judged = 0;
  double chi_square = 0;  ///< sum of the squares of the scores

  double per_thousand() const { return 1000.0 * n_alarms / n_judged; }
};

Rate healthy(const SimulatedMachine& machine, int n_runs, std::uint64_t seed) {
  const DriftMonitor fresh = monitor();
  Rate rate;
  for (int i = 0; i < n_runs; ++i) {
    SimulatedNights nights(machine, Random(seed).fork(static_cast<std::uint64_t>(i)));
    DriftMonitor watch = fresh;
    for (int night = 0; night < kNights; ++night) {
      const WatchedNight seen = *watch.add(nights.next());
      rate.n_judged += seen.is_judged;
      rate.n_alarms += !seen.alarms.empty();
      if (seen.is_judged) rate.chi_square += seen.scores.squaredNorm() / 2;
    }
  }
  std::cout << "alarms in 1000 nights: " << rate.per_thousand() << ", chi square "
            << rate.chi_square / rate.n_judged << " over " << rate.n_judged << " nights\n";
  return rate;
}

class FalseAlarms : public testing::TestWithParam<SimulatedMachine> {};

TEST_P(FalseAlarms, AreNoMoreThanStated) {
  constexpr int kRuns = 300;
  const Rate rate = healthy(GetParam(), kRuns, 1);
  const double expected = rate.n_judged / kNightsPerFalseAlarm;
  EXPECT_LE(rate.n_alarms, expected + 4 * std::sqrt(expected));
}

INSTANTIATE_TEST_SUITE_P(OfMachines,
                         FalseAlarms,
                         testing::Values(SimulatedMachine{},
                                         SimulatedMachine{.drift = 0.0001, .repeatability = 0.0001},
                                         SimulatedMachine{.drift = 0.002},
                                         SimulatedMachine{.repeatability = 0.002},
                                         SimulatedMachine{.stated = 0.0003, .correlation = 0.9},
                                         SimulatedMachine{.drift = 0.0002,
                                                          .x_per_kelvin = -0.003}));

/// Flagged on the night of a step, of the sizes of that night's forecast sigma; alarms before the
/// step do not count.
double caught_at_once(double sigmas, int n_runs, int night_of_step) {
  const DriftMonitor fresh = monitor();
  int n_caught = 0;
  for (int i = 0; i < n_runs; ++i) {
    const Random seed = Random(2).fork(static_cast<std::uint64_t>(i));
    SimulatedNights nights({}, seed);
    DriftMonitor watch = fresh;
    for (int night = 0; night < night_of_step; ++night) static_cast<void>(watch.add(nights.next()));
    DriftPoint point = nights.next();
    const DriftPrediction expected = watch.model().predict(point);
    const double turn = 6.283 * i / n_runs;
    const Eigen::Vector2d direction(std::cos(turn), std::sin(turn));
    const double sigma = 1 / std::sqrt(direction.dot(expected.cov().inverse() * direction));
    point.value += sigmas * sigma * direction;
    const WatchedNight seen = *watch.add(point);
    n_caught += !seen.alarms.empty() && seen.alarms[0].chart == DriftChart::Night;
  }
  const double share = static_cast<double>(n_caught) / n_runs;
  std::cout << "a step of " << sigmas << " sigma in night " << night_of_step
            << " is caught at once in " << share << " of " << n_runs << " runs\n";
  return share;
}

TEST(DriftMonitorSlow, FlagsAStepInItsNight) {
  constexpr int kRuns = 500;
  // A known sigma would give 0.98 at 6 sigma; one that 20 nights have shown is less sure.
  EXPECT_GE(caught_at_once(6, kRuns, 20), 0.94);
  EXPECT_GE(caught_at_once(8, kRuns, 20), 0.99);
  EXPECT_GE(caught_at_once(6, kRuns, 60), 0.96);
  EXPECT_GE(caught_at_once(8, kRuns, 60), 0.998);
}

/// Move of a value when its slow drift is flagged, um; over the counted runs.
struct Cost {
  double mean_um = 0;
  double worst_um = 0;
  int n_late = 0;  ///< beyond 10 um
};

constexpr double kTooMuch_um = 10;

Cost cost_of(double um_per_day, const SimulatedMachine& machine, const DriftMonitor& fresh) {
  constexpr int kRuns = 200;
  constexpr int kHealthyNights = 40;
  constexpr double kGivenUp_um = 60;
  Cost cost;
  for (int i = 0; i < kRuns; ++i) {
    SimulatedNights nights(machine, Random(3).fork(static_cast<std::uint64_t>(i)));
    DriftMonitor watch = fresh;
    for (int night = 0; night < kHealthyNights; ++night) {
      static_cast<void>(watch.add(nights.next()));
    }
    double moved_um = 0;
    bool is_caught = false;
    while (!is_caught && moved_um < kGivenUp_um) {
      moved_um += um_per_day;
      const Eigen::Vector2d fault = Eigen::Vector2d(0.6, -0.8) * moved_um * 1e-3;
      is_caught = !watch.add(nights.next(fault))->alarms.empty();
    }
    cost.mean_um += moved_um / kRuns;
    cost.worst_um = std::max(cost.worst_um, moved_um);
    cost.n_late += moved_um > kTooMuch_um;
  }
  std::cout << um_per_day << " um a day: flagged after " << cost.mean_um
            << " um on the average, at worst " << cost.worst_um << " of " << kRuns << " runs\n";
  return cost;
}

TEST(DriftMonitorSlow, FlagsASlowDriftBeforeItCosts10Um) {
  // Drift that is unusual of the machine, so that the charts see it, and what they miss the limit.
  const SimulatedMachine calm = {.drift = 0.0001};
  for (const double um_per_day : {0.1, 0.3, 1.0, 2.0}) {
    // One in a hundred: a random walk or a run of errors against the drift.
    EXPECT_LE(cost_of(um_per_day, calm, monitor(0.006)).n_late, 2) << um_per_day;
  }
}

TEST(DriftMonitorSlow, ChartsAloneSeeASlowDrift) {
  EXPECT_LE(cost_of(0.3, {.drift = 0.0001}, monitor()).mean_um, 10);
  EXPECT_LE(cost_of(1.0, {.drift = 0.0002}, monitor()).mean_um, 10);
}

}  // namespace
}  // namespace panelcal
