// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/model.h"

#include <gmock/gmock.h>

#include "tests/calib/panel/synthetic_panel.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using internal::coefficient_curvature;
using internal::coefficient_jacobian;
using internal::Coefficients;
using internal::coefficients;
using internal::ModelHessian;
using internal::ModelJacobian;
using internal::ModelParameters;
using test::IsNearMatrix;
using test::kAllModels;

/// Central differences of step h err by about h^2 and 1e-16 / h; parameters are of order 1.
constexpr double kStep = 1e-5;
constexpr double kDifferenceTolerance = 1e-9;

ModelParameters any_parameters(Random& random, PanelModel model) {
  ModelParameters p(parameter_count(model));
  for (Eigen::Index i = 0; i < p.size(); ++i) p[i] = random.uniform(-2, 2);
  return p;
}

ModelParameters moved(ModelParameters p, Eigen::Index i, double step) {
  p[i] += step;
  return p;
}

TEST(PanelModel, JacobianIsTheDerivativeOfTheCoefficients) {
  Random random(11);
  for (const PanelModel model : kAllModels) {
    SCOPED_TRACE(name(model));
    for (int trial = 0; trial < 20; ++trial) {
      const ModelParameters p = any_parameters(random, model);
      ModelJacobian numeric(6, p.size());
      for (Eigen::Index i = 0; i < p.size(); ++i) {
        numeric.col(i) =
            (coefficients(model, moved(p, i, kStep)) - coefficients(model, moved(p, i, -kStep))) /
            (2 * kStep);
      }
      EXPECT_THAT(coefficient_jacobian(model, p), IsNearMatrix(numeric, kDifferenceTolerance));
    }
  }
}

TEST(PanelModel, CurvatureIsTheDerivativeOfTheJacobian) {
  Random random(12);
  for (const PanelModel model : kAllModels) {
    SCOPED_TRACE(name(model));
    for (int trial = 0; trial < 20; ++trial) {
      const ModelParameters p = any_parameters(random, model);
      Coefficients weights;
      for (int i = 0; i < 6; ++i) weights[i] = random.uniform(-1, 1);
      ModelHessian numeric(p.size(), p.size());
      for (Eigen::Index i = 0; i < p.size(); ++i) {
        numeric.col(i) = (coefficient_jacobian(model, moved(p, i, kStep)) -
                          coefficient_jacobian(model, moved(p, i, -kStep)))
                             .transpose() *
                         weights / (2 * kStep);
      }
      EXPECT_THAT(coefficient_curvature(model, p, weights),
                  IsNearMatrix(numeric, kDifferenceTolerance));
    }
  }
}

TEST(PanelModel, StretchStartsExactlyAtAStretchOfAnyRotation) {
  constexpr double kRounding = 1e-15;
  for (double theta_rad = -3.1; theta_rad < 3.14; theta_rad += 0.05) {
    SCOPED_TRACE(theta_rad);
    ModelParameters truth(5);
    truth << theta_rad, 1.001, 0.998, 3.0, -4.0;
    const Coefficients a = coefficients(PanelModel::Stretch, truth);
    EXPECT_THAT(internal::start_parameters(PanelModel::Stretch, a),
                IsNearMatrix(truth, 4 * kRounding));
  }
}

TEST(PanelModel, NamesReadBack) {
  for (const PanelModel model : kAllModels) EXPECT_EQ(panel_model_from_name(name(model)), model);
  EXPECT_EQ(panel_model_from_name("stretchy"), std::nullopt);
  EXPECT_EQ(panel_model_from_name(""), std::nullopt);
}

TEST(PanelModel, CountsItsParameters) {
  EXPECT_EQ(parameter_count(PanelModel::Offset), 2);
  EXPECT_EQ(parameter_count(PanelModel::Rigid), 3);
  EXPECT_EQ(parameter_count(PanelModel::Similarity), 4);
  EXPECT_EQ(parameter_count(PanelModel::Stretch), 5);
  EXPECT_EQ(parameter_count(PanelModel::Affine), 6);
}

TEST(PanelModel, DefaultIsWhatTheManualPrescribes) {
  // CNC-7 manual, Vision Assist, G35 and G36.
  EXPECT_EQ(default_model(1), PanelModel::Offset);
  EXPECT_EQ(default_model(2), PanelModel::Rigid);
  EXPECT_EQ(default_model(3), PanelModel::Stretch);
  EXPECT_EQ(default_model(12), PanelModel::Stretch);
}

TEST(PanelModel, DefaultOfEquationsFollowsWhatTheyCanDetermine) {
  for (const bool with_scale : {false, true}) {
    SCOPED_TRACE(with_scale);
    for (const int n : {0, 1, 2}) {
      EXPECT_EQ(default_model_of_equations(n, with_scale), PanelModel::Offset);
    }
    EXPECT_EQ(default_model_of_equations(3, with_scale), PanelModel::Rigid);
    for (const int n : {4, 5}) {
      EXPECT_EQ(default_model_of_equations(n, with_scale),
                with_scale ? PanelModel::Similarity : PanelModel::Rigid);
    }
    for (const int n : {6, 7, 40}) {
      EXPECT_EQ(default_model_of_equations(n, with_scale), PanelModel::Stretch);
    }
  }
  // Points give two each: as many as Excellon counts.
  for (const int n_points : {1, 2, 3, 12}) {
    EXPECT_EQ(default_model_of_equations(2 * n_points, false), default_model(n_points));
  }
}

TEST(PanelDeformation, TakesAMapApartAndTogether) {
  Random random(13);
  for (int trial = 0; trial < 100; ++trial) {
    const double theta_rad = random.uniform(-3, 3);
    Eigen::Matrix2d upper;
    upper << random.uniform(0.5, 2), random.uniform(-1, 1), 0, random.uniform(-2, 2);
    const Eigen::Matrix2d linear = test::rotation(theta_rad) * upper;
    const PanelDeformation d = deformation_of(linear);
    EXPECT_NEAR(d.rotation_rad, theta_rad, 1e-14);
    EXPECT_NEAR(d.scale_x, upper(0, 0), 1e-14);
    EXPECT_NEAR(d.scale_y, upper(1, 1), 1e-14);
    EXPECT_NEAR(d.shear, upper(0, 1), 1e-14);
  }
}

TEST(PanelDeformation, OfASqueezedPanelIsFinite) {
  Eigen::Matrix2d linear;
  linear << 0, 0, 0, 2;
  const PanelDeformation d = deformation_of(linear);
  EXPECT_EQ(d.scale_x, 0);
  EXPECT_EQ(d.scale_y, 2);
  EXPECT_EQ(d.rotation_rad, 0);
  EXPECT_EQ(d.shear, 0);
}

}  // namespace
}  // namespace panelcal
