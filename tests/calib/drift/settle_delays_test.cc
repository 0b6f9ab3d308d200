// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/settle_delays.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

constexpr int kDelays = 12;
const Time kLongest = seconds(1);

/// 1 where a frequency looks like none at all of the delays.
double alias_with_rest(const std::vector<Time>& delays, double frequency_hz) {
  std::complex<double> sum = 0;
  for (const Time delay : delays) {
    sum += std::polar(1.0, 2 * std::numbers::pi * frequency_hz * delay.in_s());
  }
  return std::abs(sum) / static_cast<double>(delays.size());
}

double worst_alias(const std::vector<Time>& delays, double low_hz, double high_hz) {
  double worst = 0;
  for (double f_hz = low_hz; f_hz <= high_hz; f_hz += 0.05) {
    worst = std::max(worst, alias_with_rest(delays, f_hz));
  }
  return worst;
}

/// A mark that swings by 30 um until `until_s` and is at rest then.
std::vector<SettleView> seen(const std::vector<Time>& delays, double until_s) {
  std::vector<SettleView> views;
  for (const Time delay : delays) {
    const double x_mm = delay.in_s() < until_s ? 0.03 : 0;
    views.push_back(
        {delay, {position_mm<frame::Optical>(x_mm, 0.1), 1e-7 * Eigen::Matrix2d::Identity()}});
  }
  return views;
}

TEST(SettleDelays, BeginAtOnceEndAtTheLongestAndHaveNoCommonStep) {
  const std::vector<Time> delays = first_settle_delays(kDelays, kLongest);
  ASSERT_EQ(delays.size(), 12U);
  EXPECT_EQ(delays.front(), Time());
  EXPECT_EQ(delays.back(), kLongest);
  EXPECT_TRUE(std::ranges::is_sorted(delays));
  // i^2 of 11^2: every one a multiple of 1/121 s, which a swing of 121 Hz takes for rest.
  std::vector<Time> squares;
  for (int i = 0; i < kDelays; ++i) squares.push_back((i * i / 121.0) * kLongest);
  EXPECT_GT(worst_alias(squares, 15, 130), 0.999);
  EXPECT_LT(worst_alias(delays, 15, 130), 0.9);
}

TEST(SettleDelays, FillTheTimeInWhichTheMarkMoves) {
  std::vector<Time> all = first_settle_delays(kDelays, kLongest);
  const auto moving = [](Time delay) { return delay < seconds(0.2); };
  EXPECT_LT(std::ranges::count_if(all, moving), 7);
  for (int i_round = 1; i_round < 3; ++i_round) {
    const auto next = next_settle_delays(seen(all, 0.2), kDelays, i_round, kLongest, um(1));
    ASSERT_EQ(next.size(), 12U);
    EXPECT_TRUE(std::ranges::is_sorted(next));
    EXPECT_GE(next.front(), Time());
    // A little beyond the first view at rest, which came at 0.2 to 0.3 s.
    EXPECT_LE(next.back(), seconds(0.45));
    all.insert(all.end(), next.begin(), next.end());
  }
  EXPECT_GT(std::ranges::count_if(all, moving), 15);
  EXPECT_LT(worst_alias({all.begin() + kDelays, all.end()}, 10, 130), 0.6);
}

TEST(SettleDelays, StayWithinTheLongestWhatEverWasSeen) {
  const std::vector<Time> first = first_settle_delays(kDelays, kLongest);
  for (const double until_s : {0.0, 0.5, 2.0}) {
    for (const Time delay : next_settle_delays(seen(first, until_s), kDelays, 1, kLongest, um(1))) {
      EXPECT_GE(delay, Time());
      EXPECT_LE(delay, kLongest);
    }
  }
  for (const Time delay : next_settle_delays({}, kDelays, 1, kLongest, um(1))) {
    EXPECT_LE(delay, 0.25 * kLongest);
  }
}

}  // namespace
}  // namespace panelcal
