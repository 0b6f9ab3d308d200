// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/panel/fit.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The coefficients of an affine map, [l00 l01 l10 l11 tx ty], and up to six parameters of a model.
/// All sizes are bounded, so nothing here allocates.
using Coefficients = Eigen::Matrix<double, 6, 1>;
using ModelParameters = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;
using ModelJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;
using ModelHessian = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;

/// Every panel model as a parametrisation of the affine coefficients. Parameter orders:
///
///   Offset     [tx mm, ty mm]
///   Rigid      [theta rad, tx mm, ty mm]
///   Similarity [s cos(theta) 1, s sin(theta) 1, tx mm, ty mm]
///   Stretch    [theta rad, sx 1, sy 1, tx mm, ty mm]
///   Affine     [l00, l01, l10, l11, tx mm, ty mm]
Coefficients coefficients(PanelModel model, const ModelParameters& parameters);

/// d coefficients / d parameters.
ModelJacobian coefficient_jacobian(PanelModel model, const ModelParameters& parameters);

/// sum_k weights_k d^2 coefficients_k / d parameters^2; zero for the linear models.
ModelHessian coefficient_curvature(PanelModel model,
                                   const ModelParameters& parameters,
                                   const Coefficients& weights);

/// False for Rigid and Stretch, whose coefficients are not linear in the parameters.
bool is_linear(PanelModel model);

/// The linear model whose least-squares solution is a good start for `model`.
PanelModel start_model(PanelModel model);

/// The parameters of `model` nearest to a solution of its start model: for Rigid its angle, for
/// Stretch the closest R(theta) diag(sx, sy) in the sense of Frobenius, with sx > 0.
ModelParameters start_parameters(PanelModel model, const Coefficients& solution);

}  // namespace panelcal::internal
