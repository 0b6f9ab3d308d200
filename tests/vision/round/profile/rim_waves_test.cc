// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/rim_waves.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

constexpr int kWaveDraws = 2000;
constexpr double kWaveFloor = 1;

/// Powers of 2 to 11 periods of a rim whose spectrum has this own part at one period.
std::vector<double> draw_powers(Random& random, double own, double corner) {
  std::vector<double> powers;
  for (int k = 2; k <= 11; ++k) {
    const double ratio = (1 + corner * corner) / (k * k + corner * corner);
    powers.push_back(-(kWaveFloor + own * ratio * ratio) * std::log(1 - random.uniform()));
  }
  return powers;
}

/// Mean of the first wave's power over what was expected, and how often it is above 25 times that.
struct WaveHonesty {
  double ratio = 0;
  int n_far = 0;
};

WaveHonesty wave_honesty(double own, double corner, double rough_chance) {
  Random random(11);
  WaveHonesty honesty;
  for (int i = 0; i < kWaveDraws; ++i) {
    const RimWaves waves =
        extrapolate_waves(draw_powers(random, own, corner), kWaveFloor, rough_chance);
    const double first = -(kWaveFloor + own) * std::log(1 - random.uniform());
    honesty.ratio += first / waves.first / kWaveDraws;
    honesty.n_far += 2 * first > 25 * waves.first;
  }
  return honesty;
}

TEST(RimWaves, ARoundRimCostsLittle) {
  const WaveHonesty honesty = wave_honesty(0, 1, 0.04);
  // Whatever a rim's shape may hide has to be allowed for, but not as if it were there.
  EXPECT_GT(honesty.ratio, 0.85);
  EXPECT_LT(honesty.ratio, 1.05);
  EXPECT_EQ(honesty.n_far, 0);
}

TEST(RimWaves, RoughRimsAreHonest) {
  for (const double own : {0.5, 30.0, 1000.0}) {
    for (const double corner : {3.0, 5.0, 30.0}) {
      const WaveHonesty honesty = wave_honesty(own, corner, 0.5);
      EXPECT_LT(honesty.ratio, 1.25) << own << " " << corner;
      EXPECT_GT(honesty.ratio, 0.2) << own << " " << corner;
      // Smooth shapes whose waves from the second on happen to be small hide a shift: 1 in 200.
      EXPECT_LE(honesty.n_far, kWaveDraws / 200) << own << " " << corner;
    }
  }
}

TEST(RimWaves, ALoneOvalMayBeAShift) {
  std::vector<double> powers(10, kWaveFloor);
  powers[0] = 1000;
  EXPECT_GT(extrapolate_waves(powers, kWaveFloor, 0.04).first, 3000);
}

}  // namespace
}  // namespace panelcal::internal
