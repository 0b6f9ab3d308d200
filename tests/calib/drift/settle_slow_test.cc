// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <functional>
#include <vector>

#include "calib/base/statistics/random.h"
#include "calib/drift/settle.h"
#include <gtest/gtest.h>

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

TEST(SettleSlow, KnowsHowLongACreepingStageTakes) {
  constexpr int kRuns = 400;
  // |(1, -0.5)| 20 um e^(-t / 0.1 s) = 1 um
  const double truth_s = 0.1 * std::log(0.020 * std::sqrt(1.25) / 0.001);
  double chi_square = 0;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    std::string reason;
    const auto found = fit_settle(views_of(creeping, seed), um(1), &reason);
    ASSERT_TRUE(found) << reason;
    ASSERT_EQ(found->motion, SettleMotion::Creeping);
    chi_square += std::pow((found->wait.in_s() - truth_s) / found->sigma.in_s(), 2);
  }
  EXPECT_NEAR(chi_square / kRuns, 1, 4 * std::sqrt(2.0 / kRuns));
}

}  // namespace
}  // namespace panelcal
