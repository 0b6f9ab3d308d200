// SPDX-License-Identifier: Apache-2.0
// Is the reported covariance the real one? Simulated coupons, errors against truth.

#include <cmath>
#include <cstdint>
#include <string>

#include "calib/spindle/fit.h"
#include <gtest/gtest.h>

#include "tests/calib/spindle/simulated_coupon.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

constexpr std::uint64_t kFirstSeed = 2000;

/// Sums over seeds.
struct Honesty {
  int n = 0;
  int n_refused = 0;
  int n_with_outliers = 0;
  double chi_square = 0;  ///< of offsets, two degrees of freedom each
  double variance_mm2 = 0;
  int n_backlashes = 0;
  double backlash_chi_square = 0;

  double per_degree() const { return chi_square / (2.0 * n); }
  double sigma_um() const { return 1e3 * std::sqrt(variance_mm2 / n); }
};

Honesty over_seeds(const test::SimulatedCoupon& coupon, int n_seeds) {
  Honesty sums;
  for (int i = 0; i < n_seeds; ++i) {
    const auto holes = test::simulate(coupon, kFirstSeed + static_cast<std::uint64_t>(i));
    const auto result = fit_spindle_camera(holes);
    if (!result.fit) {
      ++sums.n_refused;
      continue;
    }
    ++sums.n;
    sums.n_with_outliers += result.fit->n_outliers() > 0 ? 1 : 0;
    sums.chi_square += test::squared_error(result.fit->offset, coupon.offset_mm);
    sums.variance_mm2 += result.fit->offset.cov_mm2.trace() / 2;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const BacklashEstimate& backlash = result.fit->backlash[axis];
      if (!backlash.is_determined) continue;
      const double error_um =
          backlash.value.in_um() - coupon.backlash_um[static_cast<Eigen::Index>(axis)];
      sums.backlash_chi_square += std::pow(error_um / backlash.sigma.in_um(), 2);
      ++sums.n_backlashes;
    }
  }
  return sums;
}

TEST(SpindleCameraHonesty, IntervalsOfTheScatterHoldIt) {
  for (const int rows : {3, 6}) {
    test::SimulatedCoupon coupon;
    coupon.rows = rows;
    constexpr int kSeeds = 500;
    int n = 0;
    int with_wander = 0;
    int with_repeatability = 0;
    int symmetric = 0;
    for (int i = 0; i < kSeeds; ++i) {
      const auto holes = test::simulate(coupon, kFirstSeed + static_cast<std::uint64_t>(i));
      const auto result = fit_spindle_camera(holes);
      if (!result.fit || result.fit->has_unequal_axes) continue;
      ++n;
      const ScatterEstimate& wander = result.fit->wander;
      const ScatterEstimate& looks = result.fit->repeatability;
      EXPECT_LT(wander.low[0], wander.sigma[0]);
      EXPECT_GT(wander.high[0] - wander.sigma[0], wander.sigma[0] - wander.low[0]);
      with_wander += wander.low[0] <= um(3) && um(3) <= wander.high[0];
      with_repeatability += looks.low[0] <= um(1) && um(1) <= looks.high[0];
      symmetric += std::abs((wander.sigma[0] - um(3)).in_um()) <= 1.96 * wander.error[0].in_um();
    }
    ASSERT_GT(n, 0.95 * kSeeds);
    for (const int hits : {with_wander, with_repeatability}) {
      EXPECT_GE(hits, 0.92 * n) << rows;
      EXPECT_LE(hits, 0.98 * n) << rows;
    }
    EXPECT_GT(with_wander, symmetric) << rows;
  }
}

TEST(SpindleCameraHonesty, NineHolesHoldWhatIsPromised) {
  // 3 um of wander; a detector with 0.03 px of 10 um, as for noise of 3/255; 500 seeds.
  test::SimulatedCoupon coupon;
  const Honesty sums = over_seeds(coupon, 500);
  RecordProperty("chi_square", std::to_string(sums.per_degree()));
  RecordProperty("sigma_um", std::to_string(sums.sigma_um()));
  EXPECT_GE(sums.per_degree(), 0.9);
  EXPECT_LE(sums.per_degree(), 1.1);
  EXPECT_LE(sums.sigma_um(), 1.5);
  // Stated is 0.2 %: one expected.
  EXPECT_LE(sums.n_with_outliers + sums.n_refused, 5);
}

TEST(SpindleCameraHonesty, BacklashIsAsUncertainAsItSays) {
  test::SimulatedCoupon coupon;
  coupon.backlash_um = {4, 2};
  coupon.looking = {{1, 1}, {-1, -1}};
  const Honesty sums = over_seeds(coupon, 500);
  ASSERT_EQ(sums.n_backlashes, 2 * sums.n);
  EXPECT_TRUE(test::chi_square_agrees(sums.backlash_chi_square, sums.n_backlashes));
  EXPECT_TRUE(test::chi_square_agrees(sums.chi_square, 2 * sums.n));
}

TEST(SpindleCameraHonesty, FewHolesAreNotOverrated) {
  // Four holes leave six degrees of freedom: F(2, 6), scaled to a mean of 1, has a variance of 9.
  constexpr int kSeeds = 1000;
  test::SimulatedCoupon coupon;
  coupon.rows = 2;
  coupon.columns = 2;
  const Honesty sums = over_seeds(coupon, kSeeds);
  EXPECT_EQ(sums.n, kSeeds);
  EXPECT_TRUE(test::mean_agrees(sums.per_degree(), 1, 2, kSeeds));
}

TEST(SpindleCameraHonesty, WanderBelowTheOtherNoiseIsNoTrap) {
  // The variance is at its bound of zero in many draws.
  test::SimulatedCoupon coupon;
  coupon.wander_um.setConstant(0.3);
  const Honesty sums = over_seeds(coupon, 500);
  EXPECT_TRUE(test::chi_square_agrees(sums.chi_square, 2 * sums.n));
}

}  // namespace
}  // namespace panelcal
