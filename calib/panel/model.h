// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include <Eigen/Core>

namespace panelcal {

/// The models of a panel's deformation, from stiff to soft.
enum class PanelModel {
  Offset,      ///< tx ty
  Rigid,       ///< theta tx ty
  Similarity,  ///< theta s tx ty
  Stretch,     ///< theta sx sy tx ty: R(theta) diag(sx, sy) p + t
  Affine,      ///< six free coefficients
};

int parameter_count(PanelModel model);

std::string_view name(PanelModel model);

std::optional<PanelModel> panel_model_from_name(std::string_view name);

/// The model the manual prescribes for a series of n points: 1 offset, 2 offset and rotation,
/// 3 or more offset, rotation and stretch (CNC-7 manual, Vision Assist, G36).
PanelModel default_model(int n_points);

/// The same by scalar equations, of which a point gives two and a slot one: below 3 offset, below
/// 6 rigid, or similarity if a scale is wanted and there are 4; from 6 on stretch (SIEB & MEYER
/// G31, measurement mode 5).
PanelModel default_model_of_equations(int n_equations, bool with_scale);

/// The model of a series where the machine's file asks for `wanted`. Stretch is the manuals' own
/// for many targets, so that it means "at most": too few equations for it get their usual model.
PanelModel model_at_most(PanelModel wanted, int n_equations, bool with_scale);

/// An affine map in the words of the trade: map = R(rotation) [scale_x, shear; 0, scale_y].
///
/// scale_x is never negative; a mirrored map has a negative scale_y.
struct PanelDeformation {
  double rotation_rad = 0;
  double scale_x = 1;
  double scale_y = 1;
  double shear = 0;
};

PanelDeformation deformation_of(const Eigen::Matrix2d& linear);

namespace internal {

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

}  // namespace internal
}  // namespace panelcal
