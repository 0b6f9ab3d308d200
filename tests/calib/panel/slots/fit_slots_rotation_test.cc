// SPDX-License-Identifier: Apache-2.0
// Choice of the fit among the rotations that slots leave open.
#include <cmath>
#include <numbers>

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
using test::random_parameters;
using test::random_slots;
using test::RawFitResult;
using test::RawPair;
using test::seen_through;
using test::x_at;
using test::y_at;

using Pairs = std::vector<RawPair>;

constexpr double kSigma_mm = 0.005;
/// Rounding of coordinates of 500 mm, several times over.
constexpr double kRounding_mm = 1e-11;

TEST(PanelFitSlots, TakeTheSmallerOfTwoRotations) {
  // Two y on a level line give a sine, which two angles have.
  const Pairs pairs = {y_at(0, 0), y_at(400, 0), x_at(200, 300)};
  for (const double theta_rad : {-1.2, -0.02, 0.0, 0.03, 1.2}) {
    SCOPED_TRACE(theta_rad);
    Coefficients truth;
    truth << std::cos(theta_rad), -std::sin(theta_rad), std::sin(theta_rad), std::cos(theta_rad),
        1.5, -2.5;
    const RawFitResult result = fit_raw(seen_through(pairs, truth), PanelModel::Rigid);
    ASSERT_TRUE(result.fit.has_value());
    EXPECT_THAT(coefficients_of(*result.fit), IsNearMatrix(truth, 10 * kRounding_mm));
  }
}

TEST(PanelFitSlots, ALargeRotationBeyondDoubtIsFound) {
  Random random(45);
  for (const PanelModel model : {PanelModel::Rigid, PanelModel::Similarity, PanelModel::Stretch}) {
    for (const double theta_rad : {-2.9, -1.6, -0.7, 0.5, 1.2, 2.3, 3.1, std::numbers::pi}) {
      SCOPED_TRACE(testing::Message() << name(model) << " by " << theta_rad);
      test::ModelParameters p = random_parameters(random, model);
      if (model == PanelModel::Similarity) {
        p.head<2>() << std::cos(theta_rad), std::sin(theta_rad);
      } else {
        p[0] = theta_rad;
      }
      const Coefficients truth = coefficients(model, p);
      const RawFitResult result =
          fit_raw(random_slots(random, 3, 2, truth, kSigma_mm, false), model);
      ASSERT_TRUE(result.fit.has_value());
      EXPECT_THAT(coefficients_of(*result.fit), IsNearMatrix(truth, 100 * kRounding_mm));
    }
  }
}

TEST(PanelFitSlots, AWeakCosineStillTellsALargeRotation) {
  // Levers of 400 mm for the sine, of 10 mm for the cosine: a minimum at either angle, of which
  // that near zero leaves residuals of millimetres.
  const Pairs pairs = {y_at(0, 0), y_at(400, 0), x_at(200, 0), x_at(200, 300), x_at(210, 0)};
  for (const double theta_rad : {-2.5, 2.2, 2.5, 3.0}) {
    SCOPED_TRACE(theta_rad);
    Coefficients truth;
    truth << std::cos(theta_rad), -std::sin(theta_rad), std::sin(theta_rad), std::cos(theta_rad),
        1.5, -2.5;
    const RawFitResult result = fit_raw(seen_through(pairs, truth), PanelModel::Rigid);
    ASSERT_TRUE(result.fit.has_value());
    EXPECT_THAT(coefficients_of(*result.fit), IsNearMatrix(truth, 100 * kRounding_mm));
  }
}

TEST(PanelFitSlots, NoiseDoesNotTurnThePanelOver) {
  // The rotation rests on sines, and its cosine on two x that are 10 um apart, seen to 5 um.
  Random random(47);
  const Pairs exact = {y_at(0, 0), y_at(400, 0), x_at(200, 0), x_at(200.010, 300)};
  for (int trial = 0; trial < 400; ++trial) {
    Pairs pairs = exact;
    for (RawPair& pair : pairs) {
      pair.cov_mm2 = kSigma_mm * kSigma_mm * Eigen::Matrix2d::Identity();
      pair.to_mm += test::draw(random, pair.cov_mm2);
    }
    const RawFitResult result = fit_raw(pairs, PanelModel::Rigid);
    ASSERT_TRUE(result.fit.has_value());
    EXPECT_GT(result.fit->linear(0, 0), 0.9);
  }
}

}  // namespace
}  // namespace panelcal
