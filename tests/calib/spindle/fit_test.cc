// SPDX-License-Identifier: Apache-2.0
#include "calib/spindle/fit.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "tests/calib/spindle/simulated_coupon.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using testing::HasSubstr;

constexpr std::uint64_t kSeed = 7;

SpindleCameraFit fit_of(const std::vector<CouponHole>& holes,
                        const SpindleCameraFitOptions& options = {}) {
  auto result = fit_spindle_camera(holes, options);
  EXPECT_TRUE(result.fit) << text(result.failure);
  return result.fit ? *std::move(result.fit) : SpindleCameraFit{};
}

SpindleCameraFailure failure_of(const std::vector<CouponHole>& holes,
                                const SpindleCameraFitOptions& options = {}) {
  const auto result = fit_spindle_camera(holes, options);
  EXPECT_FALSE(result.fit);
  return result.failure;
}

/// Nothing scatters; the detector says that it might by a nanometre.
test::SimulatedCoupon perfect() {
  test::SimulatedCoupon coupon;
  coupon.wander_um.setZero();
  coupon.view_stage_um = 0;
  coupon.detector_um = 1e-3;
  return coupon;
}

TEST(SpindleCameraFit, FindsTheOffsetThatPutsTheHoleUnderTheCamera) {
  const auto holes = test::simulate(perfect(), kSeed);
  const SpindleCameraFit fit = fit_of(holes);
  const auto truth = displacement_mm<frame::Machine>(80.25, -3.5);
  EXPECT_THAT(fit.offset.offset, test::IsNearPosition(truth, um(2e-3)));
  // Its sign: sent where the offset says, the optical axis stands over the hole.
  const auto spindle = fit.offset.spindle_to_see(holes[4].drilled);
  EXPECT_THAT(spindle + truth, test::IsNearPosition(holes[4].drilled, um(2e-3)));
}

TEST(SpindleCameraFit, NineHolesGiveTheMeanOfTheirMeans) {
  test::SimulatedCoupon coupon;
  const auto holes = test::simulate(coupon, kSeed);
  Eigen::Vector2d mean_mm = Eigen::Vector2d::Zero();
  for (const CouponHole& hole : holes) {
    for (const CouponView& view : hole.views) {
      mean_mm += ((hole.drilled - view.spindle).in_mm() - view.seen.position.in_mm()) / 36;
    }
  }
  const SpindleCameraFit fit = fit_of(holes);
  EXPECT_THAT(fit.offset.offset,
              test::IsNearPosition(displacement_mm<frame::Machine>(mean_mm), um(1e-6)));
  EXPECT_EQ(fit.n_used, 9);
  EXPECT_EQ(fit.n_views, 36);
  EXPECT_TRUE(fit.is_separated);
  EXPECT_NEAR(fit.degrees_of_freedom[0], 16, 0.5);
  // Half the sigma needs four times the holes, less what more degrees of freedom give:
  // 1/9 16/14 / 4 = 1/n (2n - 2) / (2n - 4) from n = 33 on.
  EXPECT_EQ(fit.more_holes_to_halve, 24);
  EXPECT_FALSE(fit.more_views_to_halve);
  EXPECT_FALSE(fit.over_picture);
}

TEST(SpindleCameraFit, NamesAHoleThatDrilledBadlyAndLeavesItOut) {
  auto holes = test::simulate({}, kSeed);
  const SpindleCameraFit sound = fit_of(holes);
  EXPECT_EQ(sound.n_outliers(), 0);
  test::move_hole(holes[3], 60, -40);
  const SpindleCameraFit fit = fit_of(holes);
  EXPECT_EQ(fit.n_outliers(), 1);
  EXPECT_TRUE(fit.holes[3].is_outlier);
  ASSERT_TRUE(fit.holes[3].chance);
  EXPECT_LT(*fit.holes[3].chance, 1e-4);
  const Eigen::Vector2d residual_um = 1e3 * fit.holes[3].residual.in_mm();
  EXPECT_NEAR(residual_um.x(), 60, 15);
  EXPECT_NEAR(residual_um.y(), -40, 15);
  EXPECT_THAT(fit.summary(), HasSubstr("from 8 holes and 32 looks, 1 left out"));
  EXPECT_THAT(fit.report(), HasSubstr("hole 4: "));
  // The rest are fitted as if it had never been drilled.
  holes.erase(holes.begin() + 3);
  EXPECT_THAT(fit.offset.offset, test::IsNearPosition(fit_of(holes).offset.offset, um(1e-6)));
}

TEST(SpindleCameraFit, TwoBadHolesDoNotHideEachOther) {
  auto holes = test::simulate({}, kSeed);
  test::move_hole(holes[0], 50, 50);
  test::move_hole(holes[8], 52, 49);
  const SpindleCameraFit fit = fit_of(holes);
  EXPECT_TRUE(fit.holes[0].is_outlier);
  EXPECT_TRUE(fit.holes[8].is_outlier);
  EXPECT_EQ(fit.n_outliers(), 2);
  EXPECT_LT(test::squared_error(fit.offset, test::SimulatedCoupon().offset_mm), 14);
}

TEST(SpindleCameraFit, RefusesACouponWhereTooMuchIsWrong) {
  auto holes = test::simulate({}, kSeed);
  test::move_hole(holes[0], 50, 50);
  test::move_hole(holes[4], -70, 0);
  test::move_hole(holes[8], 52, 49);
  EXPECT_EQ(failure_of(holes), SpindleCameraFailure::TooManyOutliers);
  holes[0] = test::simulate({}, kSeed)[0];
  EXPECT_EQ(failure_of(holes, {.max_outliers = 1}), SpindleCameraFailure::TooManyOutliers);
  EXPECT_EQ(fit_of(holes, {.max_outliers = 2}).n_outliers(), 2);
}

TEST(SpindleCameraFit, FindsBacklashAndFreesTheOffsetOfIt) {
  test::SimulatedCoupon coupon = perfect();
  coupon.backlash_um = {4, -2};
  coupon.looking = {{1, 1}, {-1, 1}, {1, -1}, {-1, -1}};
  const SpindleCameraFit fit = fit_of(test::simulate(coupon, kSeed));
  EXPECT_THAT(fit.offset.offset,
              test::IsNearPosition(displacement_mm<frame::Machine>(coupon.offset_mm), um(2e-3)));
  ASSERT_TRUE(fit.backlash[0].is_determined && fit.backlash[1].is_determined);
  EXPECT_NEAR(fit.backlash[0].value.in_um(), 4, 3e-3);
  EXPECT_NEAR(fit.backlash[1].value.in_um(), -2, 3e-3);
}

TEST(SpindleCameraFit, NeedsNoBacklashWhereLooksComeAsTheDrillDid) {
  test::SimulatedCoupon coupon = perfect();
  coupon.backlash_um = {4, -2};
  const SpindleCameraFit fit = fit_of(test::simulate(coupon, kSeed));
  EXPECT_FALSE(fit.backlash[0].is_determined);
  EXPECT_THAT(fit.offset.offset,
              test::IsNearPosition(displacement_mm<frame::Machine>(coupon.offset_mm), um(2e-3)));
  EXPECT_THAT(fit.report(), HasSubstr("backlash along x: not determined"));
}

TEST(SpindleCameraFit, RefusesLooksFromTheOtherSideOnlyUnlessTheBacklashIsKnown) {
  test::SimulatedCoupon coupon;
  coupon.looking = {{-1, 1}, {-1, 1}};
  const auto holes = test::simulate(coupon, kSeed);
  EXPECT_EQ(failure_of(holes), SpindleCameraFailure::BacklashUnknown);
  const SpindleCameraFit exact = fit_of(holes, {.backlash = um(0)});
  const SpindleCameraFit fit = fit_of(holes, {.backlash = um(5)});
  EXPECT_NEAR(fit.offset.cov_mm2(0, 0) - exact.offset.cov_mm2(0, 0), 25e-6, 1e-12);
  EXPECT_EQ(fit.offset.cov_mm2(1, 1), exact.offset.cov_mm2(1, 1));
}

TEST(SpindleCameraFit, SaysThatOneLookEachTellsNoRepeatability) {
  test::SimulatedCoupon coupon;
  coupon.looking = {{1, 1}};
  const SpindleCameraFit fit = fit_of(test::simulate(coupon, kSeed));
  EXPECT_FALSE(fit.is_separated);
  EXPECT_EQ(fit.repeatability.sigma[0], Length());
  EXPECT_FALSE(fit.more_views_to_halve);
  EXPECT_THAT(fit.report(), HasSubstr("cannot be separated"));
}

TEST(SpindleCameraFit, SaysWhenMoreLooksWouldDo) {
  test::SimulatedCoupon coupon;
  coupon.view_stage_um = 4;
  coupon.looking = {{1, 1}, {1, 1}, {1, 1}};
  auto holes = test::simulate(coupon, kSeed);
  // Each hole is put where the mean of its looks is right: no wander is left.
  for (CouponHole& hole : holes) {
    Eigen::Vector2d mean_mm = -coupon.offset_mm;
    for (const CouponView& view : hole.views) {
      mean_mm += ((hole.drilled - view.spindle).in_mm() - view.seen.position.in_mm()) / 3;
    }
    test::move_hole(hole, 1e3 * mean_mm.x(), 1e3 * mean_mm.y());
  }
  const SpindleCameraFit fit = fit_of(holes);
  ASSERT_EQ(fit.wander.sigma[0], Length());
  // Without wander four times the looks: nine more.
  EXPECT_EQ(fit.more_views_to_halve, 9);
  EXPECT_THAT(fit.report(), HasSubstr("none seen, at most about"));
}

TEST(SpindleCameraFit, FindsATurnOfTheCoupon) {
  test::SimulatedCoupon coupon;
  EXPECT_FALSE(fit_of(test::simulate(coupon, kSeed)).over_coupon->is_significant);
  coupon.coupon_turn_rad = 2e-3;
  const SpindleCameraFit fit = fit_of(test::simulate(coupon, kSeed));
  ASSERT_TRUE(fit.over_coupon);
  EXPECT_TRUE(fit.over_coupon->is_significant);
  EXPECT_NEAR(fit.over_coupon->rotation_rad, 2e-3, 4 * fit.over_coupon->rotation_sigma_rad);
  EXPECT_NEAR(fit.over_coupon->scale_ppm, 0, 4 * fit.over_coupon->scale_sigma_ppm);
}

TEST(SpindleCameraFit, FindsAWrongScaleOfTheCamera) {
  test::SimulatedCoupon coupon;
  coupon.off_middle_mm = 1;
  EXPECT_FALSE(fit_of(test::simulate(coupon, kSeed)).over_picture->is_significant);
  coupon.camera_scale_error = 3e-3;
  const SpindleCameraFit fit = fit_of(test::simulate(coupon, kSeed));
  ASSERT_TRUE(fit.over_picture);
  EXPECT_TRUE(fit.over_picture->is_significant);
  EXPECT_NEAR(fit.over_picture->scale_ppm, 3000, 4 * fit.over_picture->scale_sigma_ppm);
}

TEST(SpindleCameraFit, HoldsTheScatterAgainstTheMachineFile) {
  test::SimulatedCoupon coupon;
  const SpindleCameraFitOptions options = {.expected_wander = um(3),
                                           .expected_repeatability = um(1)};
  EXPECT_FALSE(fit_of(test::simulate(coupon, kSeed)).chance_as_expected);
  EXPECT_GT(*fit_of(test::simulate(coupon, kSeed), options).chance_as_expected, 0.01);
  coupon.wander_um.setConstant(9);  // a worn drill
  EXPECT_LT(*fit_of(test::simulate(coupon, kSeed), options).chance_as_expected, 1e-6);
}

TEST(SpindleCameraFit, TellsWhatAnErrorOfTheCameraWouldDo) {
  auto holes = test::simulate({}, kSeed);
  const SpindleCameraFit before = fit_of(holes);
  // Parameter 2 moves all that is seen by (0.01, -0.02) mm.
  for (CouponHole& hole : holes) {
    for (CouponView& view : hole.views) {
      view.by_camera.col(2) << 0.01, -0.02;
      view.seen.position = view.seen.position + displacement_mm<frame::Optical>(0.01, -0.02);
    }
  }
  const SpindleCameraFit after = fit_of(holes);
  const Eigen::Vector2d change_mm = (after.offset.offset - before.offset.offset).in_mm();
  EXPECT_THAT(after.by_camera.col(2).eval(), test::IsNearMatrix(change_mm, 1e-9));
  EXPECT_EQ(after.by_camera.col(1), Eigen::Vector2d::Zero());
}

TEST(SpindleCameraFit, RefusesWhatDeterminesNothing) {
  const auto holes = test::simulate({}, kSeed);
  EXPECT_EQ(failure_of({}), SpindleCameraFailure::TooFewHoles);
  EXPECT_EQ(failure_of({holes[0], holes[1]}), SpindleCameraFailure::TooFewHoles);
  auto bad = holes;
  bad[2].views.clear();
  EXPECT_EQ(failure_of(bad), SpindleCameraFailure::BadInput);
  bad = holes;
  bad[2].views[1].seen.position = position_mm<frame::Optical>(std::nan(""), 0);
  EXPECT_EQ(failure_of(bad), SpindleCameraFailure::BadInput);
  bad = holes;
  bad[2].views[1].seen.cov = -bad[2].views[1].seen.cov;
  EXPECT_EQ(failure_of(bad), SpindleCameraFailure::BadInput);
  bad = holes;
  bad[2].views[1].approach.x = 2;
  EXPECT_EQ(failure_of(bad), SpindleCameraFailure::BadInput);
  EXPECT_EQ(failure_of(holes, {.outlier_false_alarm = 0}), SpindleCameraFailure::BadOptions);
  EXPECT_EQ(failure_of(holes, {.significance = std::nan("")}), SpindleCameraFailure::BadOptions);
  EXPECT_EQ(failure_of(holes, {.max_outliers = -1}), SpindleCameraFailure::BadOptions);
  EXPECT_EQ(failure_of(holes, {.backlash = um(-1)}), SpindleCameraFailure::BadOptions);
}

TEST(SpindleCameraFit, DoesNotDependOnTheOrderOfHolesNorOnWhereTheCouponIs) {
  auto holes = test::simulate({}, kSeed);
  const SpindleCameraFit fit = fit_of(holes);
  std::swap(holes[0], holes[7]);
  std::swap(holes[2], holes[5]);
  const auto shift = displacement_mm<frame::Machine>(-512, 256);
  for (CouponHole& hole : holes) {
    hole.drilled = hole.drilled + shift;
    for (CouponView& view : hole.views) view.spindle = view.spindle + shift;
  }
  const SpindleCameraFit other = fit_of(holes);
  EXPECT_THAT(other.offset.offset, test::IsNearPosition(fit.offset.offset, um(1e-6)));
  EXPECT_THAT(other.offset.cov_mm2, test::IsNearMatrix(fit.offset.cov_mm2, 1e-13));
}

}  // namespace
}  // namespace panelcal
