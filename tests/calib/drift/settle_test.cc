// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/settle.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

namespace panelcal {
namespace {

constexpr double kSigma_mm = 0.0003;

/// 40 views in 0.8 s around a mark that moves in x by `motion_mm`, in y by half of that.
std::vector<SettleView> views_of(const std::function<double(double)>& motion_mm,
                                 std::uint64_t seed,
                                 double sigma_mm = kSigma_mm) {
  Random random(seed);
  std::vector<SettleView> views;
  for (int i = 0; i < 40; ++i) {
    const double t_s = 0.02 * (i + 1);
    const double x_mm = 0.3 + motion_mm(t_s) + sigma_mm * random.normal();
    const double y_mm = -0.2 - 0.5 * motion_mm(t_s) + sigma_mm * random.normal();
    views.push_back({seconds(t_s),
                     {position_mm<frame::Optical>({x_mm, y_mm}),
                      sigma_mm * sigma_mm * Eigen::Matrix2d::Identity()}});
  }
  return views;
}

double creeping(double t_s) {
  return 0.020 * std::exp(-t_s / 0.1);
}

double vibrating(double t_s) {
  return 0.020 * std::exp(-t_s / 0.15) * std::cos(2 * std::numbers::pi * 11 * t_s + 0.4);
}

TEST(Settle, KnowsHowLongACreepingStageTakes) {
  // |(1, -0.5)| 20 um e^(-t / 0.1 s) = 1 um; settle_slow_test.cc has many seeds.
  const double truth_s = 0.1 * std::log(0.020 * std::sqrt(1.25) / 0.001);
  std::string reason;
  const auto found = fit_settle(views_of(creeping, 1), um(1), &reason);
  ASSERT_TRUE(found) << reason;
  EXPECT_EQ(found->motion, SettleMotion::Creeping);
  EXPECT_NEAR(found->wait.in_s(), truth_s, 4 * found->sigma.in_s());
  EXPECT_NEAR(found->time_constant.in_s(), 0.1, 0.01);
}

TEST(Settle, KnowsFrequencyAndEnvelopeOfAVibration) {
  const double truth_s = 0.15 * std::log(0.020 * std::sqrt(1.25) / 0.001);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    std::string reason;
    const auto found = fit_settle(views_of(vibrating, seed), um(1), &reason);
    ASSERT_TRUE(found) << reason;
    EXPECT_EQ(found->motion, SettleMotion::Vibrating);
    EXPECT_NEAR(found->frequency_hz, 11, 0.2);
    EXPECT_NEAR(found->time_constant.in_s(), 0.15, 0.02);
    EXPECT_NEAR(found->wait.in_s(), truth_s, 4 * found->sigma.in_s());
    EXPECT_LT(found->sigma.in_s(), 0.05);
    EXPECT_GT(found->safe_wait(), found->wait);
  }
}

TEST(Settle, IsStillWhereNothingMoves) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto found = fit_settle(views_of([](double) { return 0.0; }, seed), um(2), nullptr);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->motion, SettleMotion::Still);
    EXPECT_EQ(found->wait, seconds(0));
    // A stage that comes to rest before the second view is not seen to move.
    EXPECT_GT(found->sigma, seconds(0));
    EXPECT_LT(found->sigma, seconds(0.02));
  }
}

/// Two rounds of 12 views in 1 s, of which five or six are within the swing; the clock is late by a
/// fraction of a millisecond.
std::vector<SettleView> few_views_of(double frequency_hz, double phase_rad, std::uint64_t seed) {
  Random random(seed);
  std::vector<SettleView> views;
  for (int i = 0; i < 24; ++i) {
    const double part = (i % 12) / 11.0;
    const double t_s = part * part + 2e-4 * random.uniform();
    const double swing_mm = 0.030 * std::exp(-t_s / 0.05) *
                            std::cos(2 * std::numbers::pi * frequency_hz * t_s + phase_rad);
    const double x_mm = swing_mm + kSigma_mm * random.normal();
    const double y_mm = kSigma_mm * random.normal();
    views.push_back({seconds(t_s),
                     {position_mm<frame::Optical>({x_mm, y_mm}),
                      kSigma_mm * kSigma_mm * Eigen::Matrix2d::Identity()}});
  }
  return views;
}

TEST(Settle, IsNeverTooShortWhereFewViewsFallWithinTheSwing) {
  const double truth_s = 0.05 * std::log(30);
  int n_ambiguous = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const double turn = static_cast<double>(seed) / 40;
    std::string reason;
    const auto found = fit_settle(few_views_of(18 + 4 * turn, 40 * turn, seed), um(1), &reason);
    ASSERT_TRUE(found) << reason;
    EXPECT_EQ(found->motion, SettleMotion::Vibrating) << seed;
    EXPECT_GE(found->safe_wait().in_s(), truth_s) << seed;
    EXPECT_LT(found->safe_wait().in_s(), truth_s + 0.06) << seed;
    n_ambiguous += found->aliases.empty() ? 0 : 1;
    for (const SettleAlias& alias : found->aliases) {
      EXPECT_GE(found->bound, alias.wait);
      EXPECT_GT(std::abs(alias.frequency_hz - found->frequency_hz), 1);
    }
  }
  EXPECT_GT(n_ambiguous, 0);
}

TEST(Settle, RefusesWhatItCannotTell) {
  std::string reason;
  const auto still = [](double) { return 0.0; };
  EXPECT_FALSE(fit_settle(views_of(still, 1), um(1), &reason));
  EXPECT_THAT(reason, testing::HasSubstr("hides a motion of 1.0 um"));
  const auto slow = [](double t_s) { return 0.1 * std::exp(-t_s / 0.4); };
  EXPECT_FALSE(fit_settle(views_of(slow, 1), um(1), &reason));
  EXPECT_THAT(reason, testing::HasSubstr("before the mark is at rest"));
  std::vector<SettleView> rough = views_of(still, 1, 0.003);
  for (SettleView& view : rough) view.seen.cov /= 100;
  EXPECT_FALSE(fit_settle(rough, um(5), &reason));
  EXPECT_THAT(reason, testing::HasSubstr("scatter"));
  std::vector<SettleView> few = views_of(creeping, 1);
  few.resize(5);
  EXPECT_FALSE(fit_settle(few, um(1), &reason));
  EXPECT_THAT(reason, testing::HasSubstr("5 times are too few"));
  EXPECT_FALSE(fit_settle({}, um(1), &reason));
  EXPECT_FALSE(fit_settle(few, um(0), &reason));
  std::vector<SettleView> broken = views_of(creeping, 1);
  broken[3].seen.position = position_mm<frame::Optical>({std::nan(""), 0});
  EXPECT_FALSE(fit_settle(broken, um(1), &reason));
  EXPECT_THAT(reason, testing::HasSubstr("no number"));
}

}  // namespace
}  // namespace panelcal
