// SPDX-License-Identifier: Apache-2.0
// Fits to slots, which show one coordinate only (SIEB & MEYER measurement mode 5).
#include <cmath>
#include <limits>

#include "calib/panel/fit.h"
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
using test::kAllModels;
using test::random_parameters;
using test::random_slots;
using test::RawFit;
using test::RawFitResult;
using test::RawPair;
using test::seen_through;
using test::x_at;
using test::y_at;

using Pairs = std::vector<RawPair>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kSigma_mm = 0.005;
/// Rounding of coordinates of 500 mm, several times over.
constexpr double kRounding_mm = 1e-11;

int equations_of(const Pairs& pairs) {
  int n = 0;
  for (const RawPair& pair : pairs) n += pair.axes == ObservedAxes::Both ? 2 : 1;
  return n;
}

/// Every target that shows both, without correlation, as two slots at its place.
Pairs taken_apart(const Pairs& pairs) {
  Pairs apart;
  for (const RawPair& pair : pairs) {
    for (const ObservedAxes axes : {ObservedAxes::X, ObservedAxes::Y}) {
      if (pair.axes != ObservedAxes::Both && pair.axes != axes) continue;
      apart.push_back(pair);
      apart.back().axes = axes;
    }
  }
  return apart;
}

/// The fewest slots that determine a model: [x, y] pairs of counts.
std::vector<std::pair<int, int>> fewest_slots(PanelModel model) {
  switch (model) {
    case PanelModel::Offset:
      return {{1, 1}};
    case PanelModel::Rigid:
      return {{1, 2}, {2, 1}};
    case PanelModel::Similarity:
      return {{1, 3}, {2, 2}, {3, 1}};
    case PanelModel::Stretch:
      return {{2, 3}, {3, 2}};
    case PanelModel::Affine:
      break;
  }
  return {{3, 3}};
}

TEST(PanelFitSlots, TheFewestRecoverEveryModelExactly) {
  Random random(40);
  const Eigen::Vector2d x_places_mm[] = {{20, 30}, {480, 350}, {60, 380}};
  const Eigen::Vector2d y_places_mm[] = {{30, 10}, {470, 260}, {100, 390}};
  for (const PanelModel model : kAllModels) {
    for (const auto& [n_x, n_y] : fewest_slots(model)) {
      for (int trial = 0; trial < 20; ++trial) {
        SCOPED_TRACE(testing::Message() << name(model) << ", " << n_x << " x, " << n_y << " y");
        const Coefficients truth = coefficients(model, random_parameters(random, model));
        Pairs pairs;
        for (const Eigen::Vector2d& p_mm : std::span(x_places_mm).first(std::size_t(n_x))) {
          pairs.push_back(x_at(p_mm.x(), p_mm.y()));
        }
        for (const Eigen::Vector2d& p_mm : std::span(y_places_mm).first(std::size_t(n_y))) {
          pairs.push_back(y_at(p_mm.x(), p_mm.y()));
        }
        pairs = seen_through(pairs, truth);
        const RawFitResult result = fit_raw(pairs, model);
        ASSERT_TRUE(result.fit.has_value());
        const Eigen::Vector2d corner_mm(500, 400);
        // Six equations magnify rounding by up to ten at the far corner.
        EXPECT_THAT(test::mapped(coefficients_of(*result.fit), corner_mm),
                    IsNearMatrix(test::mapped(truth, corner_mm), 10 * kRounding_mm));
        EXPECT_EQ(result.fit->degrees_of_freedom, 0);
      }
    }
  }
}

TEST(PanelFitSlots, MixedWithTargetsTheyRecoverEveryModelExactly) {
  Random random(41);
  for (const PanelModel model : kAllModels) {
    for (int trial = 0; trial < 30; ++trial) {
      SCOPED_TRACE(testing::Message() << name(model) << ", trial " << trial);
      const Coefficients truth = coefficients(model, random_parameters(random, model));
      const Pairs pairs = random_slots(random, 3 + trial % 3, trial % 4, truth, kSigma_mm, false);
      const RawFitResult result = fit_raw(pairs, model);
      ASSERT_TRUE(result.fit.has_value());
      const Coefficients found = coefficients_of(*result.fit);
      EXPECT_THAT(test::mapped(found, {500, 0}),
                  IsNearMatrix(test::mapped(truth, {500, 0}), 10 * kRounding_mm));
      EXPECT_EQ(result.fit->degrees_of_freedom, equations_of(pairs) - parameter_count(model));
      EXPECT_LT(result.fit->chi_square, 1e-12);
    }
  }
}

TEST(PanelFitSlots, FourGiveTheRotationOfTheManualsExample) {
  // G33: "measurement mode = 5, 2 slots into X-direction, 2 slots into Y-direction", by turns.
  constexpr double kTheta_rad = 0.002;
  constexpr double kSigma = 0.010;
  Pairs pairs = {x_at(0, -150), y_at(200, 0), x_at(0, 150), y_at(-200, 0)};
  Coefficients truth;
  truth << std::cos(kTheta_rad), -std::sin(kTheta_rad), std::sin(kTheta_rad), std::cos(kTheta_rad),
      0.3, -0.4;
  pairs = seen_through(pairs, truth);
  for (RawPair& pair : pairs) pair.cov_mm2 = kSigma * kSigma * Eigen::Matrix2d::Identity();
  const RawFitResult result =
      fit_raw(pairs, default_model_of_equations(static_cast<int>(pairs.size()), false));
  ASSERT_TRUE(result.fit.has_value());
  EXPECT_NEAR(deformation_of(result.fit->linear).rotation_rad, kTheta_rad, 1e-14);
  EXPECT_EQ(result.fit->degrees_of_freedom, 1);
  // dx = -y theta, dy = x theta, to the cosine: sigma_theta^2 = sigma^2 / sum of lever^2.
  const double variance = kSigma * kSigma / (2 * 150.0 * 150.0 + 2 * 200.0 * 200.0);
  EXPECT_NEAR(result.fit->cov(2, 2) / variance, 1, 2 * kTheta_rad * kTheta_rad);
  EXPECT_NEAR(result.fit->cov(4, 4), kSigma * kSigma / 2, 1e-12);
  EXPECT_NEAR(result.fit->cov(5, 5), kSigma * kSigma / 2, 1e-12);
}

TEST(PanelFitSlots, OffsetIsTheMeanOfWhatEachAxisShows) {
  Pairs pairs = {x_at(0, 0), x_at(300, 10), y_at(50, 400), y_at(70, 60), y_at(500, 500)};
  pairs[0].to_mm.x() += 0.02;
  pairs[2].to_mm.y() += 0.03;
  const RawFitResult result = fit_raw(pairs, PanelModel::Offset);
  ASSERT_TRUE(result.fit.has_value());
  EXPECT_THAT(result.fit->translation_mm, IsNearMatrix(Eigen::Vector2d(0.01, 0.01), 1e-13));
  EXPECT_THAT(result.fit->residuals_mm[0], IsNearMatrix(Eigen::Vector2d(0.01, 0), 1e-13));
  EXPECT_THAT(result.fit->residuals_mm[2], IsNearMatrix(Eigen::Vector2d(0, 0.02), 1e-13));
  EXPECT_NEAR(result.fit->cov(4, 4), 1e-6 / 2, 1e-18);
  EXPECT_NEAR(result.fit->cov(5, 5), 1e-6 / 3, 1e-18);
  EXPECT_EQ(result.fit->degrees_of_freedom, 3);
  // 2 (0.01 mm)^2 + (0.02 mm)^2 + 2 (0.01 mm)^2 over (1 um)^2.
  EXPECT_NEAR(result.fit->chi_square, 800, 1e-8);
}

TEST(PanelFitSlots, AnXAndAYAreWorthATarget) {
  Random random(42);
  for (const PanelModel model : kAllModels) {
    for (int trial = 0; trial < 20; ++trial) {
      SCOPED_TRACE(testing::Message() << name(model) << ", trial " << trial);
      const Coefficients truth = coefficients(model, random_parameters(random, model));
      Pairs whole = test::random_pairs(random, 4 + trial % 3, truth, 20 * kSigma_mm, true);
      for (RawPair& pair : whole) pair.cov_mm2(0, 1) = pair.cov_mm2(1, 0) = 0;
      const Pairs apart = taken_apart(whole);
      ASSERT_EQ(apart.size(), 2 * whole.size());
      const RawFit expected = *fit_raw(whole, model).fit;
      const RawFitResult result = fit_raw(apart, model);
      ASSERT_TRUE(result.fit.has_value());
      EXPECT_THAT(coefficients_of(*result.fit),
                  IsNearMatrix(coefficients_of(expected), 10 * kRounding_mm));
      EXPECT_THAT(result.fit->cov,
                  IsNearMatrix(expected.cov, 1e-9 * expected.cov.cwiseAbs().maxCoeff()));
      EXPECT_NEAR(result.fit->chi_square, expected.chi_square, 1e-9 * (1 + expected.chi_square));
      EXPECT_EQ(result.fit->degrees_of_freedom, expected.degrees_of_freedom);
      const double gain = expected.gain.cwiseAbs().maxCoeff();
      for (std::size_t i = 0; i < whole.size(); ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        Eigen::Matrix<double, 6, 2> columns;
        columns << result.fit->gain.col(4 * k), result.fit->gain.col(4 * k + 3);
        EXPECT_THAT(columns, IsNearMatrix(expected.gain.middleCols<2>(2 * k).eval(), 1e-9 * gain));
        const Eigen::Vector2d residual_mm =
            result.fit->residuals_mm[2 * i] + result.fit->residuals_mm[2 * i + 1];
        EXPECT_THAT(residual_mm, IsNearMatrix(expected.residuals_mm[i], 10 * kRounding_mm));
      }
    }
  }
}

TEST(PanelFitSlots, WhatIsNotShownHasNoInfluence) {
  Random random(43);
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (const PanelModel model : kAllModels) {
    SCOPED_TRACE(name(model));
    const Coefficients truth = coefficients(model, random_parameters(random, model));
    const Pairs pairs = random_slots(random, 3, 1, truth, kSigma_mm, true);
    const RawFit expected = *fit_raw(pairs, model).fit;
    for (const double anything : {0.0, -1.0, 1e300, kInf}) {
      Pairs other = pairs;
      for (RawPair& pair : other) {
        if (pair.axes == ObservedAxes::Both) continue;
        const int hidden = pair.axes == ObservedAxes::X ? 1 : 0;
        pair.to_mm[hidden] = anything;
        pair.cov_mm2(hidden, hidden) = pair.cov_mm2(0, 1) = pair.cov_mm2(1, 0) = anything;
      }
      const RawFitResult result = fit_raw(other, model);
      ASSERT_TRUE(result.fit.has_value());
      EXPECT_EQ(coefficients_of(*result.fit), coefficients_of(expected));
      EXPECT_EQ(result.fit->cov, expected.cov);
      EXPECT_EQ(result.fit->gain, expected.gain);
      EXPECT_EQ(result.fit->residuals_mm, expected.residuals_mm);
      EXPECT_EQ(result.fit->chi_square, expected.chi_square);
    }
  }
}

TEST(PanelFitSlots, GainIsTheDerivativeOfTheEstimate) {
  // Also where residuals are large: 20 sigma, 0.1 mm.
  Random random(44);
  constexpr double kStep_mm = 1e-3;
  for (const PanelModel model : kAllModels) {
    SCOPED_TRACE(name(model));
    const Coefficients truth = coefficients(model, random_parameters(random, model));
    Pairs pairs = random_slots(random, 3, 1, truth, 20 * kSigma_mm, true);
    const RawFit fit = *fit_raw(pairs, model).fit;
    const auto n = static_cast<Eigen::Index>(pairs.size());
    Eigen::Matrix<double, 6, Eigen::Dynamic> numeric =
        Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, 2 * n);
    for (Eigen::Index k = 0; k < 2 * n; ++k) {
      RawPair& pair = pairs[static_cast<std::size_t>(k / 2)];
      const bool is_shown = k % 2 == 0 ? observes_x(pair.axes) : observes_y(pair.axes);
      if (!is_shown) {
        EXPECT_EQ(fit.gain.col(k), Coefficients::Zero());
        EXPECT_EQ(fit.residuals_mm[static_cast<std::size_t>(k / 2)][k % 2], 0);
        continue;
      }
      const double kept_mm = pair.to_mm[k % 2];
      pair.to_mm[k % 2] = kept_mm + kStep_mm;
      const Coefficients above = coefficients_of(*fit_raw(pairs, model).fit);
      pair.to_mm[k % 2] = kept_mm - kStep_mm;
      const Coefficients below = coefficients_of(*fit_raw(pairs, model).fit);
      pair.to_mm[k % 2] = kept_mm;
      numeric.col(k) = (above - below) / (2 * kStep_mm);
    }
    // Rounding of 1e-13 mm over the step.
    EXPECT_THAT(fit.gain.topRows(4).eval(), IsNearMatrix(numeric.topRows(4).eval(), 1e-11));
    EXPECT_THAT(fit.gain.bottomRows(2).eval(), IsNearMatrix(numeric.bottomRows(2).eval(), 1e-9));
  }
}

TEST(PanelFitSlots, TheFitEndsWhereNoStepIsLeft) {
  // The gain applied to the residuals is Newton's next step. The truth is affine, so that stiffer
  // models have true residuals.
  Random random(46);
  for (const PanelModel model : kAllModels) {
    SCOPED_TRACE(name(model));
    for (int trial = 0; trial < 50; ++trial) {
      const Coefficients truth =
          coefficients(PanelModel::Affine, random_parameters(random, PanelModel::Affine));
      const Pairs pairs = random_slots(random, 3, trial % 3, truth, kSigma_mm, true);
      const RawFit fit = *fit_raw(pairs, model).fit;
      Coefficients step = Coefficients::Zero();
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        step += fit.gain.middleCols<2>(2 * static_cast<Eigen::Index>(i)) * fit.residuals_mm[i];
      }
      EXPECT_LE(step.cwiseAbs().maxCoeff(), 10 * kRounding_mm);
    }
  }
}

TEST(PanelFitSlots, KeepTheirDigitsFarFromWorkZero) {
  const auto residual_mm = [](double shift_mm) {
    Pairs pairs = {x_at(shift_mm, shift_mm),
                   x_at(shift_mm + 300, shift_mm + 200),
                   x_at(shift_mm + 300, shift_mm),
                   y_at(shift_mm, shift_mm + 200),
                   y_at(shift_mm + 300, shift_mm + 200),
                   y_at(shift_mm + 300, shift_mm)};
    pairs[2].to_mm.x() += 0.010;
    return fit_raw(pairs, PanelModel::Stretch).fit->residuals_mm[2];
  };
  // A coordinate of 1e6 mm is itself rounded to 1e-10 mm.
  EXPECT_THAT(residual_mm(1e6), IsNearMatrix(residual_mm(0), 1e-9));
  EXPECT_GT(residual_mm(0).x(), 1e-4);
}

TEST(PanelFitSlots, CarryTheirAxesAndFrames) {
  using Pair = TargetPair<frame::Actual, frame::Nominal>;
  const auto seen = [](double x_mm, double y_mm, ObservedAxes axes) {
    const Eigen::Vector2d to_mm(observes_x(axes) ? x_mm + 1 : kNan,
                                observes_y(axes) ? y_mm + 2 : kNan);
    return Pair{position_mm<frame::Nominal>(x_mm, y_mm),
                {position_mm<frame::Actual>(to_mm), 1e-6 * Eigen::Matrix2d::Identity()},
                axes};
  };
  const std::vector<Pair> pairs = {seen(0, 0, ObservedAxes::Both),
                                   seen(100, 40, ObservedAxes::Y),
                                   seen(30, 80, ObservedAxes::X)};
  const auto result = fit_panel(std::span<const Pair>(pairs), PanelModel::Rigid);
  ASSERT_TRUE(result.fit.has_value());
  EXPECT_EQ(result.fit->pairs[1].axes, ObservedAxes::Y);
  EXPECT_EQ(result.fit->degrees_of_freedom, 1);
  EXPECT_EQ(result.fit->residuals[1].in_mm().x(), 0);
  EXPECT_THAT(result.fit->map(position_mm<frame::Nominal>(100, 50)).position,
              test::IsNearPosition(position_mm<frame::Actual>(101, 52), um(1e-6)));
}

}  // namespace
}  // namespace panelcal
