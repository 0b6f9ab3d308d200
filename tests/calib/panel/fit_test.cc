// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/fit.h"

#include <algorithm>

#include <gmock/gmock.h>

#include "tests/calib/panel/synthetic_panel.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using internal::coefficients;
using internal::fit_raw;
using test::Coefficients;
using test::coefficients_of;
using test::IsNearMatrix;
using test::IsNearPosition;
using test::kAllModels;
using test::ModelParameters;
using test::random_pairs;
using test::random_parameters;
using test::RawFit;
using test::RawFitResult;
using test::RawPair;
using test::seen_exactly;

using Pairs = std::vector<RawPair>;

/// Rounding of coordinates of 500 mm, several times over.
constexpr double kRounding_mm = 1e-11;
constexpr double kSigma_mm = 0.005;

int fewest_targets(PanelModel model) {
  return (parameter_count(model) + 1) / 2;
}

TEST(PanelFit, RecoversEveryModelExactlyFromExactTargets) {
  Random random(1);
  for (const PanelModel model : kAllModels) {
    for (int n = fewest_targets(model); n < 9; ++n) {
      SCOPED_TRACE(testing::Message() << name(model) << ", " << n << " targets");
      const Coefficients truth = coefficients(model, random_parameters(random, model));
      const Pairs pairs = random_pairs(random, n, truth, kSigma_mm, false);
      const RawFitResult result = fit_raw(pairs, model);
      ASSERT_TRUE(result.fit.has_value());
      for (const RawPair& pair : pairs) {
        const Eigen::Vector2d fitted = test::mapped(coefficients_of(*result.fit), pair.from_mm);
        EXPECT_THAT(fitted, IsNearMatrix(pair.to_mm, kRounding_mm));
      }
      EXPECT_EQ(result.fit->degrees_of_freedom, 2 * n - parameter_count(model));
      EXPECT_LT(result.fit->chi_square, 1e-12);
    }
  }
}

TEST(PanelFit, RecoversHalfTurnsAndLargeRotations) {
  Random random(2);
  for (const PanelModel model : {PanelModel::Rigid, PanelModel::Similarity, PanelModel::Stretch}) {
    for (double theta_rad = -3.1; theta_rad < 3.15; theta_rad += 0.31) {
      SCOPED_TRACE(testing::Message() << name(model) << " by " << theta_rad);
      ModelParameters p = random_parameters(random, model);
      if (model == PanelModel::Similarity) {
        p.head<2>() << std::cos(theta_rad), std::sin(theta_rad);
      } else {
        p[0] = theta_rad;
      }
      const Coefficients truth = coefficients(model, p);
      const RawFitResult result = fit_raw(random_pairs(random, 4, truth, kSigma_mm, false), model);
      ASSERT_TRUE(result.fit.has_value());
      EXPECT_THAT(coefficients_of(*result.fit), IsNearMatrix(truth, 100 * kRounding_mm));
    }
  }
}

TEST(PanelFit, KeepsItsDigitsFarFromWorkZero) {
  // The residual of one target that is 10 um off must not depend on where the panel lies.
  const auto residual_mm = [](double shift_mm) {
    Pairs pairs = {seen_exactly(shift_mm, shift_mm),
                   seen_exactly(shift_mm + 300, shift_mm),
                   seen_exactly(shift_mm, shift_mm + 200),
                   seen_exactly(shift_mm + 300, shift_mm + 200)};
    pairs[3].to_mm.x() += 0.010;
    return fit_raw(pairs, PanelModel::Stretch).fit->residuals_mm[3];
  };
  // A coordinate of 1e6 mm is itself rounded to 1e-10 mm.
  EXPECT_THAT(residual_mm(1e6), IsNearMatrix(residual_mm(0), 1e-9));
}

TEST(PanelFit, TwoPointsShareADistanceMismatch) {
  // Vision Assist, G36 with two points: offset and rotation only; 40 um too far apart leaves
  // 20 um at each end, along the line.
  const Pairs pairs = {{{0, 0}, {-0.02, 0}, Eigen::Matrix2d::Identity()},
                       {{100, 0}, {100.02, 0}, Eigen::Matrix2d::Identity()}};
  const RawFitResult result = fit_raw(pairs, PanelModel::Rigid);
  ASSERT_TRUE(result.fit.has_value());
  EXPECT_THAT(result.fit->linear, IsNearMatrix(Eigen::Matrix2d::Identity(), 1e-15));
  EXPECT_THAT(result.fit->residuals_mm[0], IsNearMatrix(Eigen::Vector2d(-0.02, 0), 1e-13));
  EXPECT_THAT(result.fit->residuals_mm[1], IsNearMatrix(Eigen::Vector2d(0.02, 0), 1e-13));
  EXPECT_EQ(result.fit->degrees_of_freedom, 1);
}

TEST(PanelFit, FollowsTheBetterMeasurement) {
  Pairs pairs = {seen_exactly(0, 0), seen_exactly(0, 0)};
  pairs[0].cov_mm2 *= 4;
  pairs[0].to_mm = {0.05, 0};
  const RawFitResult result = fit_raw(pairs, PanelModel::Offset);
  ASSERT_TRUE(result.fit.has_value());
  EXPECT_NEAR(result.fit->translation_mm.x(), 0.01, 1e-15);
}

TEST(PanelFit, OrderOfTargetsDoesNotMatter) {
  Random random(3);
  for (const PanelModel model : kAllModels) {
    SCOPED_TRACE(name(model));
    const Coefficients truth = coefficients(model, random_parameters(random, model));
    Pairs pairs = random_pairs(random, 6, truth, kSigma_mm, true);
    const RawFit forward = *fit_raw(pairs, model).fit;
    std::reverse(pairs.begin(), pairs.end());
    const RawFit backward = *fit_raw(pairs, model).fit;
    EXPECT_THAT(coefficients_of(backward), IsNearMatrix(coefficients_of(forward), kRounding_mm));
    EXPECT_NEAR(backward.chi_square, forward.chi_square, 1e-9);
  }
}

TEST(PanelFit, TurningWhatIsSeenTurnsTheFit) {
  Random random(4);
  const Eigen::Matrix2d turn = test::rotation(1.1);
  for (const PanelModel model :
       {PanelModel::Rigid, PanelModel::Similarity, PanelModel::Stretch, PanelModel::Affine}) {
    SCOPED_TRACE(name(model));
    const Coefficients truth = coefficients(model, random_parameters(random, model));
    Pairs pairs = random_pairs(random, 5, truth, kSigma_mm, true);
    const RawFit before = *fit_raw(pairs, model).fit;
    for (RawPair& pair : pairs) {
      pair.to_mm = turn * pair.to_mm;
      pair.cov_mm2 = turn * pair.cov_mm2 * turn.transpose();
    }
    const RawFit after = *fit_raw(pairs, model).fit;
    EXPECT_THAT(after.linear, IsNearMatrix((turn * before.linear).eval(), 1e-12));
    EXPECT_NEAR(after.chi_square, before.chi_square, 1e-7);
  }
}

TEST(PanelFit, GainIsTheDerivativeOfTheEstimate) {
  // Also where residuals are large: the measurements are 20 sigma off, 0.1 mm.
  Random random(5);
  constexpr double kStep_mm = 1e-3;
  for (const PanelModel model : kAllModels) {
    SCOPED_TRACE(name(model));
    const Coefficients truth = coefficients(model, random_parameters(random, model));
    Pairs pairs = random_pairs(random, 5, truth, 20 * kSigma_mm, true);
    const RawFit fit = *fit_raw(pairs, model).fit;
    Eigen::Matrix<double, 6, Eigen::Dynamic> numeric(6, 10);
    for (Eigen::Index k = 0; k < 10; ++k) {
      double& coordinate_mm = pairs[static_cast<std::size_t>(k / 2)].to_mm[k % 2];
      const double kept_mm = coordinate_mm;
      coordinate_mm = kept_mm + kStep_mm;
      const Coefficients above = coefficients_of(*fit_raw(pairs, model).fit);
      coordinate_mm = kept_mm - kStep_mm;
      const Coefficients below = coefficients_of(*fit_raw(pairs, model).fit);
      coordinate_mm = kept_mm;
      numeric.col(k) = (above - below) / (2 * kStep_mm);
    }
    // Rounding of 1e-13 mm over the step.
    EXPECT_THAT(fit.gain.topRows(4).eval(), IsNearMatrix(numeric.topRows(4).eval(), 1e-11));
    EXPECT_THAT(fit.gain.bottomRows(2).eval(), IsNearMatrix(numeric.bottomRows(2).eval(), 1e-9));
  }
}

TEST(PanelFit, EndsWhereNoStepIsLeft) {
  // The gain applied to the residuals is Newton's next step.
  Random random(8);
  for (const PanelModel model : kAllModels) {
    SCOPED_TRACE(name(model));
    for (int trial = 0; trial < 50; ++trial) {
      const Coefficients truth =
          coefficients(PanelModel::Affine, random_parameters(random, PanelModel::Affine));
      const Pairs pairs = random_pairs(random, 4, truth, kSigma_mm, true);
      const RawFit fit = *fit_raw(pairs, model).fit;
      Eigen::VectorXd residuals_mm(8);
      for (Eigen::Index i = 0; i < 4; ++i) {
        residuals_mm.segment<2>(2 * i) = fit.residuals_mm[static_cast<std::size_t>(i)];
      }
      const Coefficients step = fit.gain * residuals_mm;
      // Some of the random targets lie nearly in one line, which magnifies rounding.
      EXPECT_LE(step.cwiseAbs().maxCoeff(), 100 * kRounding_mm);
    }
  }
}

TEST(PanelFit, CovarianceIsTheGainTimesTheMeasurements) {
  Random random(6);
  for (const PanelModel model : kAllModels) {
    SCOPED_TRACE(name(model));
    const Coefficients truth = coefficients(model, random_parameters(random, model));
    const Pairs pairs = random_pairs(random, 4, truth, kSigma_mm, true);
    const RawFit fit = *fit_raw(pairs, model).fit;
    const Eigen::Matrix<double, 6, 6> expected =
        fit.gain * test::stacked_covariance(pairs) * fit.gain.transpose();
    EXPECT_THAT(fit.cov, IsNearMatrix(expected, 1e-12 * expected.cwiseAbs().maxCoeff()));
    EXPECT_EQ(fit.cov, fit.cov.transpose());
  }
}

TEST(PanelFit, CarriesFramesAndPairs) {
  using Pair = TargetPair<frame::Actual, frame::Nominal>;
  std::vector<Pair> pairs;
  for (const Eigen::Vector2d& p_mm :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(100, 0), Eigen::Vector2d(0, 50)}) {
    pairs.push_back({position_mm<frame::Nominal>(p_mm),
                     {position_mm<frame::Actual>(p_mm + Eigen::Vector2d(1, 2)),
                      1e-6 * Eigen::Matrix2d::Identity()}});
  }
  const auto result = fit_panel(std::span<const Pair>(pairs), PanelModel::Stretch);
  ASSERT_TRUE(result.fit.has_value());
  EXPECT_EQ(result.fit->model, PanelModel::Stretch);
  EXPECT_EQ(result.fit->pairs.size(), 3U);
  EXPECT_EQ(result.fit->residuals.size(), 3U);
  EXPECT_EQ(result.fit->degrees_of_freedom, 1);
  const PositionEstimate<frame::Actual> corner =
      result.fit->map(position_mm<frame::Nominal>(100, 50));
  EXPECT_THAT(corner.position, IsNearPosition(position_mm<frame::Actual>(101, 52), um(1e-6)));
  EXPECT_GT(corner.cov(0, 0), 0);
}

TEST(PanelFit, PassesFailuresOn) {
  using Pair = TargetPair<frame::Actual, frame::Nominal>;
  const std::vector<Pair> pairs(3);
  const auto result = fit_panel(std::span<const Pair>(pairs), PanelModel::Offset);
  ASSERT_FALSE(result.fit.has_value());
  EXPECT_EQ(result.failure, FitFailure::BadCovariance);
}

}  // namespace
}  // namespace panelcal
