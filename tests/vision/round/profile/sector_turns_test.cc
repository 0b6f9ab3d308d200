// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/sector_turns.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

constexpr Eigen::Index kTurnSectors = 50;

Eigen::VectorXd wave_around(double amplitude, int n_periods, double phase_rad) {
  Eigen::VectorXd values(kTurnSectors);
  for (Eigen::Index i = 0; i < kTurnSectors; ++i) {
    const double phi_rad = 2 * std::numbers::pi * static_cast<double>(i) / kTurnSectors;
    values[i] = amplitude * std::cos(n_periods * phi_rad - phase_rad);
  }
  return values;
}

TEST(SectorTurns, AreTheWaveOfEverySector) {
  const SectorTurns turns(kTurnSectors);
  // More periods than sectors go around more than once from one to the next.
  for (const int n_periods : {0, 1, 7, 49, 50, 51, 133}) {
    Eigen::Index n_visited = 0;
    turns.for_each(n_periods, [&](Eigen::Index i, const std::complex<double>& turn) {
      EXPECT_EQ(i, n_visited++);
      const double phi_rad =
          2 * std::numbers::pi * n_periods * static_cast<double>(i) / kTurnSectors;
      EXPECT_NEAR(std::abs(turn - std::polar(1.0, phi_rad)), 0, 1e-12) << n_periods << ' ' << i;
    });
    EXPECT_EQ(n_visited, kTurnSectors);
  }
}

/// n sectors of a cos have n/2 a^2 / 2 of power as a sum of squares, all of it in its own wave.
TEST(WavePowers, TellWavesApart) {
  const double amplitude = 0.3;
  const auto powers = wave_powers(wave_around(amplitude, 4, 0.7), {}, 2, 6);
  ASSERT_EQ(powers.size(), 5);
  for (std::size_t k = 0; k < powers.size(); ++k) {
    const double expected = k == 2 ? amplitude * amplitude * kTurnSectors / 4 : 0;
    EXPECT_NEAR(powers[k], expected, 1e-12) << k + 2;
  }
}

TEST(WavePowers, OfNoiseAreItsVarianceWhateverIsUsed) {
  constexpr int kTrials = 400;
  const double sigma = 0.2;
  Random random(3);
  for (const bool is_whole : {true, false}) {
    std::vector<char> use;
    if (!is_whole) {
      use.assign(kTurnSectors, 1);
      for (std::size_t i = 10; i < 30; ++i) use[i] = 0;
    }
    double mean = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      Eigen::VectorXd values(kTurnSectors);
      for (double& value : values) value = sigma * random.normal();
      for (const double power : wave_powers(values, use, 2, 9)) mean += power / (8 * kTrials);
    }
    // Eight waves of 400 trials, each of an exponential distribution: 5 deviations by chance.
    EXPECT_NEAR(mean, sigma * sigma, 5 * sigma * sigma / std::sqrt(8.0 * kTrials) * 1.5);
  }
}

TEST(WavePowers, OfNothingUsedAreZero) {
  const std::vector<char> use(kTurnSectors, 0);
  for (const double power : wave_powers(wave_around(1, 3, 0), use, 2, 5)) EXPECT_EQ(power, 0);
}

}  // namespace
}  // namespace panelcal::internal
