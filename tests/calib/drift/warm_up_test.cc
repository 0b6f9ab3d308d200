// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/warm_up.h"

#include <cmath>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

namespace panelcal {
namespace {

constexpr double kSigma_mm = 0.0005;
constexpr double kTimeConstant_s = 1500;

/// Every 5 minutes for two hours.
std::vector<WarmUpSample> morning(const Eigen::Vector2d& cold_mm, std::uint64_t seed) {
  Random random(seed);
  std::vector<WarmUpSample> samples;
  for (int i = 0; i <= 24; ++i) {
    const double t_s = 300.0 * i;
    const Eigen::Vector2d noise_mm(random.normal(), random.normal());
    samples.push_back({seconds(t_s),
                       Eigen::Vector2d(51, -4) + cold_mm * std::exp(-t_s / kTimeConstant_s) +
                           kSigma_mm * noise_mm,
                       kSigma_mm});
  }
  return samples;
}

TEST(WarmUp, IsFoundAsWellAsItSays) {
  constexpr int kRuns = 400;
  const Eigen::Vector2d cold_mm(0.012, -0.005);
  const double wait_s = kTimeConstant_s * std::log(cold_mm.norm() / 0.002);
  double chi_square = 0;
  double chi_square_of_wait = 0;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    std::string reason;
    const auto found = fit_warm_up(morning(cold_mm, seed), 0.002, &reason);
    ASSERT_TRUE(found) << reason;
    ASSERT_TRUE(found->is_seen);
    const double error_s = found->time_constant.in_s() - kTimeConstant_s;
    chi_square += std::pow(error_s / found->time_constant_sigma.in_s(), 2);
    chi_square_of_wait += std::pow((found->wait.in_s() - wait_s) / found->wait_sigma.in_s(), 2);
  }
  const double band = 4 * std::sqrt(2.0 / kRuns);
  EXPECT_NEAR(chi_square / kRuns, 1, band);
  EXPECT_NEAR(chi_square_of_wait / kRuns, 1, band);
}

TEST(WarmUp, IsNotSeenWhereThereIsNone) {
  int n_seen = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const auto found = fit_warm_up(morning({0, 0}, seed), 0.002, nullptr);
    ASSERT_TRUE(found);
    n_seen += found->is_seen;
    if (!found->is_seen) {
      EXPECT_EQ(found->wait, seconds(0));
    }
  }
  EXPECT_LE(n_seen, 1);
}

TEST(WarmUp, RefusesWhatItCannotTell) {
  std::string reason;
  std::vector<WarmUpSample> samples = morning({0.012, 0}, 1);
  EXPECT_FALSE(fit_warm_up(samples, 0, &reason));
  samples.resize(5);
  EXPECT_FALSE(fit_warm_up(samples, 0.002, &reason));
  EXPECT_THAT(reason, testing::HasSubstr("too few"));
  samples = morning({0.5, 0}, 1);
  samples.resize(8);
  EXPECT_FALSE(fit_warm_up(samples, 0.002, &reason));
  EXPECT_THAT(reason, testing::HasSubstr("the samples end after 35 min"));
  samples = morning({0.012, 0}, 1);
  samples[4].value(0) += 0.02;
  EXPECT_FALSE(fit_warm_up(samples, 0.002, &reason));
  EXPECT_THAT(reason, testing::HasSubstr("do not follow"));
  samples[4].value.resize(1);
  EXPECT_FALSE(fit_warm_up(samples, 0.002, &reason));
}

}  // namespace
}  // namespace panelcal
