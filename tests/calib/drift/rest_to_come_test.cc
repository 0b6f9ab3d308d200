// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/rest_to_come.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

namespace panelcal {
namespace {

constexpr double kLimit_um = 2;
constexpr double kInterval_s = 120;

/// Values in um; x goes by cold_um, y by half of it the other way.
WarmUpSample sample(double t_s, double cold_um, double tau_s, double sigma_um, Random& random) {
  const double left = std::exp(-t_s / tau_s);
  const double x_um = cold_um * left + sigma_um * random.normal();
  return {seconds(t_s),
          Eigen::Vector2d(x_um, -0.5 * cold_um * left + sigma_um * random.normal()),
          sigma_um};
}

TEST(RestToCome, IsSeldomLessThanTheTruthWhenOneStopsAtIt) {
  constexpr int kRuns = 30;
  for (const double tau_s : {300.0, 900.0, 1500.0}) {
    for (const double cold_um : {10.0, 40.0, 150.0}) {
      int n_early = 0;
      for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
        Random random(seed);
        std::vector<WarmUpSample> samples;
        double t_s = 0;
        for (bool is_warm = false; !is_warm && t_s < 14400; t_s += kInterval_s) {
          samples.push_back(sample(t_s, cold_um, tau_s, 0.6, random));
          is_warm = samples.size() >= 6 && most_to_come(samples) < kLimit_um;
        }
        const double stopped_s = samples.back().since_start.in_s();
        const double rest_um = cold_um * std::hypot(1, 0.5) * std::exp(-stopped_s / tau_s);
        n_early += rest_um > kLimit_um;
      }
      // Two sigmas and three; a look after the other gives chance some more to try.
      EXPECT_LE(n_early, kRuns / 15) << tau_s << " s, " << cold_um << " um";
    }
  }
}

TEST(RestToCome, OfAMachineThatDoesNotMoveGetsSmall) {
  Random random(3);
  std::vector<WarmUpSample> samples;
  for (int i = 0; i < 6; ++i) samples.push_back(sample(kInterval_s * i, 0, 1, 0.6, random));
  const double at_first_um = most_to_come(samples);
  EXPECT_GT(at_first_um, kLimit_um);
  for (int i = 6; i < 60; ++i) samples.push_back(sample(kInterval_s * i, 0, 1, 0.6, random));
  EXPECT_LT(most_to_come(samples), kLimit_um);
}

TEST(RestToCome, OfTooFewSamplesIsNotKnown) {
  Random random(3);
  const std::vector<WarmUpSample> samples = {sample(0, 1, 1, 1, random),
                                             sample(1, 1, 1, 1, random)};
  EXPECT_EQ(most_to_come(samples), std::numeric_limits<double>::infinity());
  const WarmUpSample one = sample(5, 1, 1, 1, random);
  EXPECT_EQ(most_to_come(std::vector{one, one, one}), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace panelcal
