// SPDX-License-Identifier: Apache-2.0
#include "panelcal/calib/base/estimate.h"

#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::IsNearMatrix;

TEST(Estimate, UncertainTranslationIsTheSameEverywhere) {
  TransformEstimate<frame::Actual, frame::Nominal> t;
  t.cov.bottomRightCorner<2, 2>() << 4, 1, 1, 9;
  const Eigen::Matrix2d expected = t.cov.bottomRightCorner<2, 2>();
  EXPECT_EQ(t(position_mm<frame::Nominal>(0, 0)).cov, expected);
  EXPECT_EQ(t(position_mm<frame::Nominal>(300, -200)).cov, expected);
}

TEST(Estimate, UncertainRotationGrowsWithDistance) {
  // A turn by theta moves (x, y) by theta (-y, x).
  constexpr double kSigma_rad = 1e-4;
  TransformEstimate<frame::Actual, frame::Nominal> t;
  Eigen::Matrix<double, 6, 1> turn;
  turn << 0, -1, 1, 0, 0, 0;
  t.cov = kSigma_rad * kSigma_rad * turn * turn.transpose();
  const Eigen::Vector2d moved_mm(-200 * kSigma_rad, 300 * kSigma_rad);
  EXPECT_THAT(t(position_mm<frame::Nominal>(300, 200)).cov,
              IsNearMatrix((moved_mm * moved_mm.transpose()).eval(), 1e-16));
}

TEST(Estimate, PropagatesThroughAJacobian) {
  Eigen::Matrix2d j;
  j << 0, 2, 1, 0;
  Eigen::Matrix2d expected;
  expected << 16, 0, 0, 1;
  EXPECT_EQ(propagate(j, Eigen::Vector2d(1, 4).asDiagonal()), expected);
}

}  // namespace
}  // namespace panelcal
