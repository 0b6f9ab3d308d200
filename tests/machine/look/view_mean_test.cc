// SPDX-License-Identifier: Apache-2.0
#include "machine/look/view_mean.h"

#include <cmath>
#include <vector>

#include "calib/base/statistics/random.h"
#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::internal {
namespace {

using test::IsNearMatrix;

constexpr int kTrials = 4000;
constexpr double kDelta_mm = 5;

std::vector<ViewDeviation> views(const Eigen::Vector2d& shift_mm, double turn_rad) {
  std::vector<ViewDeviation> out;
  for (const Eigen::Vector2d& offset : {Eigen::Vector2d(1, 0),
                                        Eigen::Vector2d(0, 1),
                                        Eigen::Vector2d(-1, 0),
                                        Eigen::Vector2d(0, -1)}) {
    const Eigen::Vector2d at_mm = kDelta_mm * offset;
    const Eigen::Vector2d turned_mm = turn_rad * Eigen::Vector2d(-at_mm.y(), at_mm.x());
    Eigen::Matrix2d cov;
    cov << 4e-8, 1e-8, 1e-8, 2e-8;
    out.push_back({at_mm, shift_mm + turned_mm, cov, std::nullopt});
  }
  return out;
}

Eigen::Vector2d draw(const Eigen::Matrix2d& cov, Random& random) {
  const Eigen::Matrix2d l = cov.llt().matrixL();
  const double x = random.normal();
  const double y = random.normal();
  return l * Eigen::Vector2d(x, y);
}

// Tables of the chi-square distribution, 99 %.
TEST(ChiSquareLimit, IsThatOfTheTables) {
  EXPECT_NEAR(chi_square_limit(1), 6.635, 0.12);
  EXPECT_NEAR(chi_square_limit(2), 9.210, 0.1);
  EXPECT_NEAR(chi_square_limit(5), 15.086, 0.05);
  EXPECT_NEAR(chi_square_limit(10), 23.209, 0.05);
  EXPECT_NEAR(chi_square_limit(100), 135.807, 0.05);
}

TEST(MeanOfViews, IsThePlainMeanAndATurnIsTakenOut) {
  const auto mean = mean_of_views(views({0.3, -0.2}, 0.004));
  ASSERT_TRUE(mean);
  EXPECT_NEAR((mean->deviation_mm - Eigen::Vector2d(0.3, -0.2)).norm(), 0, 1e-12);
  EXPECT_NEAR(mean->rotation_rad, 0.004, 1e-12);
  for (const double r_mm : mean->residual_mm) EXPECT_NEAR(r_mm, 0, 1e-12);
  EXPECT_THAT(mean->cov_mm2, IsNearMatrix(views({0, 0}, 0)[0].cov_mm2 / 4, 1e-15));
}

TEST(MeanOfViews, UnequalDeviationsAreStillAveraged) {
  auto four = views({0, 0}, 0);
  four[0].deviation_mm << 0.04, 0.01;
  four[3].deviation_mm << -0.02, 0.05;
  const auto mean = mean_of_views(four);
  ASSERT_TRUE(mean);
  EXPECT_NEAR((mean->deviation_mm - Eigen::Vector2d(0.005, 0.015)).norm(), 0, 1e-12);
}

TEST(MeanOfViews, CovarianceIsTheRealOne) {
  Random random(5);
  double sum = 0;
  for (int i = 0; i < kTrials; ++i) {
    auto four = views({0, 0}, 0.001);
    for (ViewDeviation& view : four) view.deviation_mm += draw(view.cov_mm2, random);
    const auto mean = mean_of_views(four);
    ASSERT_TRUE(mean);
    sum += mean->deviation_mm.dot(mean->cov_mm2.ldlt().solve(mean->deviation_mm)) / 2;
  }
  // Four sigmas of a mean of chi-squares; one in a hundred is enlarged without need.
  EXPECT_NEAR(sum / kTrials, 1, 4 / std::sqrt(kTrials) + 0.01);
}

TEST(MeanOfViews, MarksOutOfPlaceEnlargeTheCovariance) {
  Random random(6);
  double sum = 0;
  const double misplaced_mm = 0.005;  // 25 sigmas of a view
  for (int i = 0; i < kTrials; ++i) {
    auto four = views({0, 0}, 0);
    for (ViewDeviation& view : four) {
      view.cov_mm2 = 4e-8 * Eigen::Matrix2d::Identity();
      view.deviation_mm += misplaced_mm * Eigen::Vector2d(random.normal(), random.normal());
    }
    const auto mean = mean_of_views(four);
    ASSERT_TRUE(mean);
    sum += mean->deviation_mm.squaredNorm() / mean->cov_mm2.trace();
  }
  // The scale comes from five residuals: F(2, 5) has a mean of 5/3.
  EXPECT_NEAR(sum / kTrials, 5.0 / 3, 0.3);
}

TEST(MeanOfViews, OneMarkAtFaultIsSeen) {
  auto four = views({0.1, 0.1}, 0.002);
  four[2].deviation_mm += Eigen::Vector2d(0, 0.2);
  const auto mean = mean_of_views(four);
  ASSERT_TRUE(mean);
  EXPECT_GT(mean->residual_mm[2], 0.09);
}

TEST(MeanOfViews, SlotsGiveTheCoordinateTheySee) {
  auto four = views({0.3, -0.2}, 0);
  for (std::size_t k = 0; k < 4; ++k) {
    const bool sees_x = k % 2 == 0;
    four[k].blind = sees_x ? Eigen::Vector2d(0, 1) : Eigen::Vector2d(1, 0);
    four[k].deviation_mm(sees_x ? 1 : 0) = 77;  // must not matter
  }
  four[0].deviation_mm.x() += 0.01;
  const auto mean = mean_of_views(four);
  ASSERT_TRUE(mean);
  EXPECT_NEAR((mean->deviation_mm - Eigen::Vector2d(0.305, -0.2)).norm(), 0, 1e-12);
}

TEST(MeanOfViews, ParallelSlotsLeaveACoordinateOpen) {
  auto four = views({0.3, -0.2}, 0);
  for (ViewDeviation& view : four) view.blind = Eigen::Vector2d(1, 0);
  EXPECT_FALSE(mean_of_views(four));
  EXPECT_FALSE(mean_of_views({}));
}

TEST(ExcessScatter, IsNoneWhileItMayBeChance) {
  Random random(9);
  Eigen::Matrix2d cov;
  cov << 4e-8, 1e-8, 1e-8, 2e-8;
  int n_enlarged = 0;
  for (int i = 0; i < kTrials; ++i) {
    std::vector<PositionEstimate<frame::Actual>> places;
    for (int k = 0; k < 4; ++k) {
      const Eigen::Vector2d at = Eigen::Vector2d(3, 4) + draw(cov, random);
      places.push_back({position_mm<frame::Actual>(at), cov});
    }
    n_enlarged += excess_scatter(places, 2).trace() > 0;
  }
  EXPECT_NEAR(n_enlarged / static_cast<double>(kTrials), 0.01, 0.006);
}

TEST(ExcessScatter, AddsWhatTheScatterShows) {
  Random random(10);
  const Eigen::Matrix2d cov = 1e-8 * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d real = 100 * cov;
  std::vector<PositionEstimate<frame::Actual>> places;
  for (int k = 0; k < 400; ++k) {
    const Eigen::Vector2d at = draw(real, random);
    places.push_back({position_mm<frame::Actual>(at), cov});
  }
  EXPECT_NEAR((excess_scatter(places, 2) * 400).trace() / (99 * cov).trace(), 1, 0.2);
  EXPECT_NEAR(scatter_of(places).in_mm().x(), 1e-3, 0.15e-3);
}

TEST(MeanOfViews, AveragesWhatTheCameraMovesAndTakesOutItsTurn) {
  // All four views shifted alike by one parameter, turned about the middle by another.
  auto four = views({0, 0}, 0);
  for (ViewDeviation& view : four) {
    view.by_camera.col(2) << 0.01, -0.02;
    view.by_camera.col(1) << -view.offset_mm.y(), view.offset_mm.x();
  }
  const auto mean = mean_of_views(four);
  ASSERT_TRUE(mean);
  CameraJacobian expected = CameraJacobian::Zero();
  expected.col(2) << 0.01, -0.02;
  EXPECT_NEAR((mean->by_camera - expected).norm(), 0, 1e-12);
}

}  // namespace
}  // namespace panelcal::internal
