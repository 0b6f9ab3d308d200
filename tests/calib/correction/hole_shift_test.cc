// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/hole_shift.h"

#include <cmath>
#include <limits>
#include <utility>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

/// Of sums of a few hundred thousand doubles.
constexpr double kRounding = 1e-10;

Position<frame::Nominal> at(double x_mm, double y_mm) {
  return position_mm<frame::Nominal>(x_mm, y_mm);
}
Displacement<frame::Actual> by(double x_mm, double y_mm) {
  return displacement_mm<frame::Actual>(x_mm, y_mm);
}

TEST(HoleShift, OfSpindleCameraOffsetsIsTheirChange) {
  SpindleCameraOffset before;
  before.offset = displacement_mm<frame::Machine>(50, -3);
  SpindleCameraOffset after = before;
  after.offset = displacement_mm<frame::Machine>(50.010, -3.002);
  const HoleShift shift = shift_between(before, after);
  for (const auto& hole : {at(0, 0), at(400, -30)}) {
    // A mark seen on the axis at the same stage place is now believed to be elsewhere.
    const auto stage = position_mm<frame::Machine>(hole.in_mm());
    const Displacement<frame::Machine> believed =
        after.optical_axis(stage) - before.optical_axis(stage);
    EXPECT_THAT(shift(hole).in_mm(), test::IsNearMatrix(believed.in_mm(), kRounding));
  }
}

TEST(HoleShift, OfCorrectionsIsZeroBetweenEqualOnes) {
  const CorrectionStack stack;
  EXPECT_EQ(shift_between(stack, stack)(at(300, 200)), by(0, 0));
}

TEST(HoleShiftStatistics, HasNoSummaryWithoutHoles) {
  EXPECT_FALSE(HoleShiftStatistics().summary());
}

TEST(HoleShiftStatistics, CountsByHand) {
  HoleShiftStatistics statistics;
  // Lengths 0.005 k for k = 1..20 along (3, 4): the 95 % one is the 19th.
  for (int k = 1; k <= 20; ++k) {
    ASSERT_TRUE(statistics.add(at(k, -k), by(0.003 * k, 0.004 * k)));
  }
  ASSERT_TRUE(statistics.add(at(99, 99), by(-0.06, -0.08)));  // as long as the 20th, but later
  const HoleShiftSummary s = statistics.summary().value();
  EXPECT_EQ(s.n_holes, 21u);
  EXPECT_NEAR(s.max.in_mm(), 0.1, kRounding);
  EXPECT_NEAR(s.p95.in_mm(), 0.1, kRounding);  // rank 20 of 21
  EXPECT_EQ(s.p95_relative_error, 0);
  EXPECT_EQ(s.worst_hole, at(20, -20));
  EXPECT_NEAR(s.mean.in_mm(), (0.005 * 210 + 0.1) / 21, kRounding);
  EXPECT_NEAR(s.rms.in_mm(), std::sqrt((0.005 * 0.005 * 2870 + 0.01) / 21), kRounding);
  EXPECT_NEAR(s.mean_shift.in_mm().x(), (0.003 * 210 - 0.06) / 21, kRounding);
  EXPECT_NEAR(s.mean_shift.in_mm().y(), (0.004 * 210 - 0.08) / 21, kRounding);
}

TEST(HoleShiftStatistics, TakesTheNearestRank) {
  for (const auto& [n, rank] : {std::pair(1, 1), {2, 2}, {19, 19}, {20, 19}, {40, 38}, {41, 39}}) {
    HoleShiftStatistics statistics;
    for (int k = n; k >= 1; --k) ASSERT_TRUE(statistics.add(at(0, 0), by(k, 0)));
    EXPECT_EQ(statistics.summary()->p95.in_mm(), rank) << n;
  }
}

/// A square of side a that is turned by a small angle t about its middle: a hole at r moves by t r.
TEST(HoleShiftStatistics, FindsTheCornerOfATurnedPanel) {
  constexpr double kAngle_rad = 1e-4;
  HoleShiftStatistics statistics;
  for (int i = -50; i <= 50; ++i) {
    for (int j = -50; j <= 50; ++j) {
      ASSERT_TRUE(statistics.add(at(4 * i, 4 * j), by(-kAngle_rad * 4 * j, kAngle_rad * 4 * i)));
    }
  }
  const HoleShiftSummary s = statistics.summary().value();
  EXPECT_NEAR(s.max.in_um(), 20 * std::sqrt(2), 1e-9);
  EXPECT_EQ(s.worst_hole, at(-200, -200));
  // rms of r over the lattice: a^2 (2/3) (n + 1)/n with a = 200 mm, n = 50.
  EXPECT_NEAR(s.rms.in_um(), 20 * std::sqrt(2.0 / 3 * 51 / 50), 1e-9);
  EXPECT_NEAR(s.mean_shift.in_mm().norm(), 0, kRounding);
}

/// Truth: the exact quantile of the same draws. Lengths over nine decades, 200,000 draws.
TEST(HoleShiftStatistics, HistogramKeepsItsStatedError) {
  constexpr int kHoles = 200000;
  Random random(20261121);
  HoleShiftStatistics exact;
  HoleShiftStatistics coarse(1000);
  for (int i = 0; i < kHoles; ++i) {
    const double length_mm = std::pow(10.0, random.uniform(-7, 2));
    ASSERT_TRUE(exact.add(at(i, 0), by(length_mm, 0)));
    ASSERT_TRUE(coarse.add(at(i, 0), by(length_mm, 0)));
  }
  const HoleShiftSummary truth = exact.summary().value();
  const HoleShiftSummary s = coarse.summary().value();
  EXPECT_EQ(truth.p95_relative_error, 0);
  EXPECT_EQ(s.p95_relative_error, HoleShiftStatistics::kHistogramRelativeError);
  EXPECT_LE(std::abs(s.p95 / truth.p95 - 1), s.p95_relative_error);
  EXPECT_EQ(s.n_holes, truth.n_holes);
  EXPECT_EQ(s.max, truth.max);
  EXPECT_EQ(s.rms, truth.rms);
}

TEST(HoleShiftStatistics, HistogramHoldsExtremes) {
  for (const double length_mm : {0.0, 1e-30, 1e-9, 1e-3, 1e6}) {
    HoleShiftStatistics statistics(1);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(statistics.add(at(i, 0), by(0, length_mm)));
    const double tolerance_mm = HoleShiftStatistics::kHistogramRelativeError * length_mm + 1e-9;
    EXPECT_NEAR(statistics.summary()->p95.in_mm(), length_mm, tolerance_mm);
  }
}

TEST(HoleShiftStatistics, RefusesShiftsThatAreNone) {
  HoleShiftStatistics statistics;
  ASSERT_TRUE(statistics.add(at(1, 1), by(0.5, 0)));
  for (const double bad_mm :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e7}) {
    EXPECT_THAT(statistics.add(at(7, 8), by(bad_mm, 0)),
                FailsWith(Code::CalibrationInvalid, "(7, 8) mm"));
  }
  EXPECT_EQ(statistics.summary()->n_holes, 1u);
  EXPECT_EQ(statistics.summary()->max, mm(0.5));
}

}  // namespace
}  // namespace panelcal
