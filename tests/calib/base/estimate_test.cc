// SPDX-License-Identifier: Apache-2.0
#include "calib/base/estimate.h"

#include <cstdint>

#include "calib/base/statistics/random.h"
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

TEST(Estimate, CovarianceIsThatOfTheJacobian) {
  constexpr std::uint64_t kSeed = 20261121;
  constexpr double kRounding = 1e-15;  // of the sum of the terms' magnitudes
  Random random(kSeed);
  for (int i = 0; i < 10'000; ++i) {
    Eigen::Matrix<double, 6, 6> root;
    for (double& element : root.reshaped()) element = random.normal();
    // Coefficients of the linear part are known better by the size of a panel.
    const double panel_mm = random.uniform(1, 1000);
    root.topRows<4>() /= panel_mm;
    TransformEstimate<frame::Actual, frame::Nominal> t;
    t.cov = root * root.transpose();
    // Products like those of CorrectionStack are symmetric but for their rounding.
    t.cov(0, 4) *= 1 + 1e-15 * random.normal();
    const Eigen::Vector2d p_mm(random.uniform(-panel_mm, panel_mm),
                               random.uniform(-panel_mm, panel_mm));
    Eigen::Matrix<double, 2, 6> j;
    j << p_mm.x(), p_mm.y(), 0, 0, 1, 0, 0, 0, p_mm.x(), p_mm.y(), 0, 1;
    const Eigen::Matrix2d expected = j * t.cov * j.transpose();
    const Eigen::Matrix2d magnitude = j.cwiseAbs() * t.cov.cwiseAbs() * j.cwiseAbs().transpose();

    const Eigen::Matrix2d cov = t(position_mm<frame::Nominal>(p_mm)).cov;
    EXPECT_EQ(cov(0, 1), cov(1, 0));
    EXPECT_TRUE(((cov - expected).cwiseAbs().array() <= kRounding * magnitude.array()).all())
        << "seed " << kSeed << ", draw " << i << "\n"
        << cov << "\nexpected\n"
        << expected;
  }
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
