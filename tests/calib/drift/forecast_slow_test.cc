// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <iostream>

#include "calib/drift/forecast.h"
#include <gtest/gtest.h>

#include "tests/calib/drift/simulated_nights.h"

namespace panelcal {
namespace {

using test::SimulatedNights;

DriftModel learned(int n_nights, SimulatedNights& nights) {
  DriftModel model = *DriftModel::make(2, {});
  for (int night = 0; night < n_nights; ++night) static_cast<void>(model.add(nights.next()));
  return model;
}

/// Over many machines, the share of errors beyond the tolerance at the time that was named.
TEST(DriftForecastSlow, KeepsItsWord) {
  constexpr int kRuns = 400;
  constexpr double kProbability = 0.1;
  const ForecastLimits limits = {
      .tolerance = 0.004, .probability = kProbability, .temperature_c = 21.0};
  int n_asked = 0;
  int n_beyond = 0;
  for (int i = 0; i < kRuns; ++i) {
    Random random = Random(6).fork(static_cast<std::uint64_t>(i));
    SimulatedNights nights({.temperature_sigma = 0}, random);
    const DriftModel model = learned(30, nights);
    const Eigen::VectorXd in_force = model.forecast(*model.last(), 21.0).mean();
    const DrillForecast told = *may_drill(model, in_force, *model.last(), limits);
    if (told.answer != DrillAnswer::Until) continue;
    ++n_asked;
    // From the last night's truth the level walks on.
    const double days = static_cast<double>((told.until - *model.last()).count()) / 86400;
    const double step = 0.0005 * std::sqrt(days);
    const Eigen::Vector2d then =
        nights.truth() + step * Eigen::Vector2d(random.normal(), random.normal());
    n_beyond += (then - in_force).norm() > limits.tolerance;
  }
  EXPECT_GT(n_asked, kRuns * 9 / 10);
  const double share = static_cast<double>(n_beyond) / n_asked;
  EXPECT_NEAR(share, kProbability, 4 * std::sqrt(kProbability / n_asked));
  std::cout << "error beyond the tolerance at the time named: " << share << " of " << n_asked
            << "\n";
}

}  // namespace
}  // namespace panelcal
