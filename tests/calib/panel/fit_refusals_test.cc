// SPDX-License-Identifier: Apache-2.0
// Fits of input that no good panel gives: too few, degenerate, mirrored, absurd.
#include <algorithm>
#include <limits>

#include "calib/panel/fit.h"
#include <Eigen/LU>
#include <gmock/gmock.h>

#include "tests/calib/panel/synthetic_panel.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using internal::fit_raw;
using test::Coefficients;
using test::coefficients_of;
using test::IsNearMatrix;
using test::kAllModels;
using test::random_pairs;
using test::RawFitResult;
using test::RawPair;
using test::seen_exactly;

using Pairs = std::vector<RawPair>;

void expect_fails(const Pairs& pairs, PanelModel model, FitFailure failure) {
  SCOPED_TRACE(name(model));
  const RawFitResult result = fit_raw(pairs, model);
  ASSERT_FALSE(result.fit.has_value());
  EXPECT_EQ(result.failure, failure);
}

TEST(PanelFit, RefusesTooFewTargets) {
  expect_fails({}, PanelModel::Offset, FitFailure::TooFewTargets);
  const Pairs one = {seen_exactly(0, 0)};
  expect_fails(one, PanelModel::Rigid, FitFailure::TooFewTargets);
  expect_fails(one, PanelModel::Similarity, FitFailure::TooFewTargets);
  const Pairs two = {seen_exactly(0, 0), seen_exactly(100, 0)};
  expect_fails(two, PanelModel::Stretch, FitFailure::TooFewTargets);
  expect_fails(two, PanelModel::Affine, FitFailure::TooFewTargets);
}

TEST(PanelFit, RefusesCoincidentTargets) {
  const Pairs pairs(3, seen_exactly(300, 200));
  EXPECT_TRUE(fit_raw(pairs, PanelModel::Offset).fit.has_value());
  for (const PanelModel model :
       {PanelModel::Rigid, PanelModel::Similarity, PanelModel::Stretch, PanelModel::Affine}) {
    expect_fails(pairs, model, FitFailure::Degenerate);
  }
}

TEST(PanelFit, RefusesCollinearTargets) {
  // Turned by many angles, so that rounding cannot hide the line.
  for (double angle_rad = 0; angle_rad < 3.2; angle_rad += 0.1) {
    SCOPED_TRACE(angle_rad);
    Pairs pairs;
    for (const double along_mm : {0.0, 130.0, 410.0, 500.0}) {
      const Eigen::Vector2d p_mm = along_mm * test::rotation(angle_rad).col(0);
      pairs.push_back(seen_exactly(p_mm.x() + 1000, p_mm.y() - 700));
    }
    expect_fails(pairs, PanelModel::Stretch, FitFailure::Degenerate);
    expect_fails(pairs, PanelModel::Affine, FitFailure::Degenerate);
    EXPECT_TRUE(fit_raw(pairs, PanelModel::Rigid).fit.has_value());
    EXPECT_TRUE(fit_raw(pairs, PanelModel::Similarity).fit.has_value());
  }
}

TEST(PanelFit, RefusesThreeTargetsOfWhichTwoCoincide) {
  // The manual's second listing repeats G46X01Y02: four equations for five parameters.
  const Pairs pairs = {seen_exactly(38.1, 0), seen_exactly(25.4, 50.8), seen_exactly(25.4, 50.8)};
  expect_fails(pairs, PanelModel::Stretch, FitFailure::Degenerate);
}

TEST(PanelFit, FitsWhatIsOnlyNearlyCollinear) {
  // A tenth of a millimetre across half a metre: the fit answers, and knows how badly.
  Pairs pairs = {seen_exactly(0, 0), seen_exactly(250, 0.1), seen_exactly(500, 0)};
  const RawFitResult result = fit_raw(pairs, PanelModel::Stretch);
  ASSERT_TRUE(result.fit.has_value());
  EXPECT_THAT(result.fit->linear, IsNearMatrix(Eigen::Matrix2d::Identity(), 1e-9));
  EXPECT_GT(std::sqrt(result.fit->cov(3, 3)), 0.005);
}

TEST(PanelFit, RefusesWhatIsNoCovariance) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Eigen::Vector3d> bad = {// xx, xy, yy
                                            {0, 0, 0},
                                            {1, 0, 0},
                                            {1, 1, 1},
                                            {1, 2, 1},
                                            {-1, 0, 1},
                                            {kInf, 0, 1},
                                            {1, kNoNumber, 1},
                                            {1e-320, 0, 1e-320},
                                            {1e-200, 0, 1},
                                            {1e300, 0, 1e300}};
  for (const Eigen::Vector3d& v : bad) {
    SCOPED_TRACE(testing::Message() << v.transpose());
    Pairs pairs = {seen_exactly(0, 0), seen_exactly(1, 0), seen_exactly(0, 1)};
    pairs[1].cov_mm2 << v[0], v[1], v[1], v[2];
    for (const PanelModel model : kAllModels) {
      expect_fails(pairs, model, FitFailure::BadCovariance);
    }
  }
  Pairs crooked = {seen_exactly(0, 0)};
  crooked[0].cov_mm2 << 1, 0.5, 0.4, 1;
  expect_fails(crooked, PanelModel::Offset, FitFailure::BadCovariance);
}

TEST(PanelFit, RefusesNumbersThatAreNotFinite) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    Pairs pairs = {seen_exactly(0, 0), seen_exactly(1, 0), seen_exactly(bad, 1)};
    for (const PanelModel model : kAllModels) {
      if (model == PanelModel::Offset && bad == 1e300) continue;
      EXPECT_FALSE(fit_raw(pairs, model).fit.has_value()) << name(model) << bad;
    }
  }
}

Pairs mirrored_square() {
  Pairs pairs = {
      seen_exactly(0, 0), seen_exactly(100, 0), seen_exactly(0, 100), seen_exactly(100, 100)};
  for (RawPair& pair : pairs) pair.to_mm.y() = -pair.to_mm.y();
  return pairs;
}

TEST(PanelFit, AMirroredPanelLeavesStiffModelsWithHugeResiduals) {
  for (const PanelModel model : {PanelModel::Offset, PanelModel::Rigid, PanelModel::Similarity}) {
    SCOPED_TRACE(name(model));
    const RawFitResult result = fit_raw(mirrored_square(), model);
    ASSERT_TRUE(result.fit.has_value());
    double worst_mm = 0;
    for (const Eigen::Vector2d& r_mm : result.fit->residuals_mm) {
      worst_mm = std::max(worst_mm, r_mm.norm());
    }
    EXPECT_GT(worst_mm, 50);
    EXPECT_GE(result.fit->linear.determinant(), 0);
    EXPECT_TRUE(result.fit->cov.allFinite());
  }
}

TEST(PanelFit, AMirroredPanelShowsAsNegativeScale) {
  for (const PanelModel model : {PanelModel::Stretch, PanelModel::Affine}) {
    SCOPED_TRACE(name(model));
    const RawFitResult result = fit_raw(mirrored_square(), model);
    ASSERT_TRUE(result.fit.has_value());
    EXPECT_LT(result.fit->chi_square, 1e-12);
    EXPECT_NEAR(deformation_of(result.fit->linear).scale_y, -1, 1e-14);
  }
}

TEST(PanelFit, AnswersWhateverIsMeasured) {
  // Measurements that have nothing to do with the targets: an answer or a failure, never NaN.
  Random random(7);
  int n_answers = 0;
  for (int trial = 0; trial < 400; ++trial) {
    Pairs pairs = random_pairs(random, 3 + trial % 5, Coefficients::Zero(), 0.005, false);
    for (RawPair& pair : pairs) {
      if (trial % 3 == 0) continue;  // all seen at one place
      pair.to_mm = {random.uniform(-500, 500), random.uniform(-500, 500)};
    }
    for (const PanelModel model : kAllModels) {
      const RawFitResult result = fit_raw(pairs, model);
      if (!result.fit) continue;
      ++n_answers;
      EXPECT_TRUE(coefficients_of(*result.fit).allFinite());
      EXPECT_TRUE(result.fit->cov.allFinite());
      EXPECT_TRUE(std::isfinite(result.fit->chi_square));
    }
  }
  EXPECT_GT(n_answers, 1500);
}

}  // namespace
}  // namespace panelcal
