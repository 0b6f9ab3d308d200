// SPDX-License-Identifier: Apache-2.0
// From drilling to the fitted offset, through rendered pictures: is the covariance the real one?

#include <cmath>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "tests/calib/spindle/simulated_coupon.h"
#include "tests/machine/calibrate/spindle/coupon_job.h"

namespace panelcal {
namespace {

TEST(SpindleCalibrationHonesty, PicturesOfNineHolesGiveTheOffsetAsWellAsIsSaid) {
  // 10 um a pixel, noise 3/255, 3 um of drill wander, 1 um of the stage.
  constexpr int kSeeds = 500;
  const test::TemporaryFolder folder;
  const auto config = test::coupon_machine(folder.path());
  ASSERT_TRUE(config) << config.error().text();
  double chi_square = 0;
  double variance_mm2 = 0;
  double detector_mm2 = 0;
  double n_looks = 0;
  int n_fits = 0;
  int n_missed = 0;
  int n_above = 0;  // runs whose own sigma is more than was asked for
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    auto machine = SimCoupon::create(*config, test::usual_scatter(seed));
    ASSERT_TRUE(machine) << machine.error().text();
    Coupon coupon = test::three_by_three();
    coupon.looking = {{1, 1}, {-1, -1}};
    const auto sights = test::run_coupon(*config, coupon, *machine);
    ASSERT_TRUE(sights) << sights.error().text();
    n_missed += static_cast<int>(sights->missed.size());
    for (const CouponHole& hole : sights->holes) {
      for (const CouponView& view : hole.views) {
        detector_mm2 += view.seen.cov.trace() / 2;
        ++n_looks;
      }
    }
    const auto result = fit_spindle_camera(sights->holes);
    if (!result.fit) continue;
    ++n_fits;
    chi_square += test::squared_error(result.fit->offset, machine->true_offset().offset.in_mm());
    variance_mm2 += result.fit->offset.cov_mm2.trace() / 2;
    n_above += result.fit->offset.cov_mm2.trace() / 2 > 1.5e-3 * 1.5e-3 ? 1 : 0;
  }
  const double per_degree = chi_square / (2.0 * n_fits);
  const double sigma_um = 1e3 * std::sqrt(variance_mm2 / n_fits);
  RecordProperty("chi_square", std::to_string(per_degree));
  RecordProperty("sigma_um", std::to_string(sigma_um));
  RecordProperty("share_above", std::to_string(static_cast<double>(n_above) / n_fits));
  RecordProperty("detector_um", std::to_string(1e3 * std::sqrt(detector_mm2 / n_looks)));
  EXPECT_EQ(n_missed, 0);
  EXPECT_GE(n_fits, kSeeds - 3);
  EXPECT_GE(per_degree, 0.9);
  EXPECT_LE(per_degree, 1.1);
  EXPECT_LE(sigma_um, 1.5);
}

}  // namespace
}  // namespace panelcal
