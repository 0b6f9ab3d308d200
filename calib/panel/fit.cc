// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/fit.h"

#include <cmath>
#include <limits>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/panel/model.h"
#include "calib/panel/system.h"
#include <Eigen/QR>

namespace panelcal::internal {
namespace {

/// Least curvature of the cost, relative to Gauss-Newton's, that Newton's method is trusted with.
/// It is 1 for exact data and near it while residuals are small against the targets' distances.
constexpr double kLeastCurvature = 0.1;
constexpr int kMaxPanelIterations = 50;
/// Chi square by which a large rotation must fit slots better than a small one: five sigmas.
constexpr double kWorthALargeRotation = 25;

/// The solution, with the square root of its covariance: cov = propagation propagation^T and
/// d coefficients = gain (d right-hand side of the normal equations).
struct Solution {
  Coefficients a;
  ModelJacobian propagation;
  Eigen::Matrix<double, 6, 6> gain;
};

bool determines(const Spread& s, PanelModel model) {
  if (model == PanelModel::Offset) return true;
  if (!(s.along_mm > kCoincident_mm)) return false;
  if (model == PanelModel::Rigid || model == PanelModel::Similarity) return true;
  return s.across_mm > kCollinear * s.along_mm;
}

/// The model's parameters where nothing has moved or turned.
ModelParameters at_rest(PanelModel model) {
  if (is_linear(model)) return ModelParameters::Zero(parameter_count(model));
  return start_parameters(model, coefficients(PanelModel::Offset, ModelParameters::Zero(2)));
}

/// True if the equations, linearised at rest, have full rank in the model's parameters. For targets
/// alone this is determines(Spread).
bool determines(const SquareRoot& structure, PanelModel model) {
  const ModelJacobian by_parameters =
      structure.factor() * coefficient_jacobian(model, at_rest(model));
  Eigen::ColPivHouseholderQR<ModelJacobian> qr(by_parameters);
  qr.setThreshold(kCollinear);
  return qr.rank() == parameter_count(model);
}

/// One linearisation of the system at given parameters, in parameters whitened by the QR
/// decomposition, where the Gauss-Newton matrix is the identity.
struct Linearised {
  ModelHessian parameters_from_white;  ///< p x p
  ModelHessian curvature;              ///< identity, plus what residuals and curved model add
  ModelParameters descent;             ///< minus the gradient
};

std::optional<Linearised> linearise(const SquareRoot& system,
                                    PanelModel model,
                                    const ModelParameters& parameters) {
  const ModelJacobian j = coefficient_jacobian(model, parameters);
  const ModelJacobian weighted = system.factor() * j;
  const int n = parameter_count(model);
  Eigen::ColPivHouseholderQR<ModelJacobian> qr(weighted);
  qr.setThreshold(1e-13);
  if (qr.rank() < n) return std::nullopt;

  Linearised out;
  const ModelHessian upper = qr.matrixR().topRows(n).triangularView<Eigen::Upper>();
  const ModelHessian inverse =
      upper.triangularView<Eigen::Upper>().solve(ModelHessian(ModelHessian::Identity(n, n)));
  out.parameters_from_white = qr.colsPermutation() * inverse;
  const Coefficients a = coefficients(model, parameters);
  const Coefficients residual = system.target() - system.factor() * a;
  const ModelParameters gradient = weighted.transpose() * residual;
  out.descent = out.parameters_from_white.transpose() * gradient;
  out.curvature = ModelHessian::Identity(n, n);
  if (is_linear(model)) return out;
  const Coefficients weights = system.factor().transpose() * residual;
  const ModelHessian bend = coefficient_curvature(model, parameters, weights);
  out.curvature -= out.parameters_from_white.transpose() * bend * out.parameters_from_white;
  const ModelHessian least = kLeastCurvature * ModelHessian::Identity(n, n);
  // Residuals as large as the panel itself: Gauss-Newton still descends.
  if (!Cholesky(out.curvature - least).is_definite()) out.curvature.setIdentity();
  return out;
}

ModelParameters newton_step(const Linearised& at) {
  const ModelParameters white = Cholesky(at.curvature).solve(Eigen::VectorXd(at.descent));
  return at.parameters_from_white * white;
}

/// The longest of step, step/2, step/4 ... that does not raise the cost (beyond rounding).
ModelParameters shortened(const SquareRoot& system,
                          PanelModel model,
                          const ModelParameters& at,
                          ModelParameters step) {
  const double rounding = 1e-26 * system.target().squaredNorm();
  const double bound = system.cost(coefficients(model, at)) * (1 + 1e-9) + rounding;
  for (int i = 0; i < 30 && system.cost(coefficients(model, at + step)) > bound; ++i) step *= 0.5;
  return step;
}

/// The least-squares parameters of a linear model.
std::optional<ModelParameters> solve_linear(const SquareRoot& system, PanelModel model) {
  ModelParameters parameters = ModelParameters::Zero(parameter_count(model));
  const std::optional<Linearised> linear = linearise(system, model, parameters);
  if (!linear) return std::nullopt;
  parameters += newton_step(*linear);
  return parameters;
}

/// The minimum of a model that is not linear, downhill from the solution of a linear one.
std::optional<ModelParameters> descend(const SquareRoot& system,
                                       PanelModel model,
                                       PanelModel first) {
  const std::optional<ModelParameters> linear = solve_linear(system, first);
  if (!linear) return std::nullopt;
  ModelParameters parameters = start_parameters(model, coefficients(first, *linear));
  double last_length = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMaxPanelIterations; ++i) {
    const std::optional<Linearised> at = linearise(system, model, parameters);
    if (!at) return std::nullopt;
    const ModelParameters step = shortened(system, model, parameters, newton_step(*at));
    parameters += step;
    const double length = step.norm();
    const bool at_rounding = length < 1e-9 && length > 0.5 * last_length;
    if (length <= 1e-15 || at_rounding || !std::isfinite(length)) break;
    last_length = length;
  }
  return parameters;
}

/// `structure` is there if some targets are slots. They may leave several rotations open: two
/// heights give a sine, which fits a panel that lies nearly straight and one that is turned over.
/// The start at an offset finds the first. Where the linear model is determined too, it must show a
/// large rotation beyond doubt, for slots determine it badly.
std::optional<ModelParameters> minimise(const SquareRoot& system,
                                        const std::optional<SquareRoot>& structure,
                                        PanelModel model) {
  const PanelModel first = start_model(model);
  if (first == model) return solve_linear(system, model);
  if (!structure) return descend(system, model, first);

  const std::optional<ModelParameters> small = descend(system, model, PanelModel::Offset);
  if (!determines(*structure, first)) return small;
  const std::optional<ModelParameters> any = descend(system, model, first);
  if (!small || !any) return small ? small : any;
  const double cost_of_small = system.cost(coefficients(model, *small));
  const double cost_of_any = system.cost(coefficients(model, *any));
  return cost_of_small <= cost_of_any + kWorthALargeRotation ? small : any;
}

std::optional<Solution> solve_panel(const SquareRoot& system,
                                    const std::optional<SquareRoot>& structure,
                                    PanelModel model) {
  const std::optional<ModelParameters> parameters = minimise(system, structure, model);
  if (!parameters) return std::nullopt;
  const std::optional<Linearised> at = linearise(system, model, *parameters);
  if (!at) return std::nullopt;
  Solution solution;
  solution.a = coefficients(model, *parameters);
  const ModelJacobian coefficients_from_white =
      coefficient_jacobian(model, *parameters) * at->parameters_from_white;
  const ModelHessian inverse = Cholesky(at->curvature).inverse();
  solution.propagation = coefficients_from_white * inverse;
  solution.gain = solution.propagation * coefficients_from_white.transpose();
  if (!solution.a.allFinite() || !solution.gain.allFinite()) return std::nullopt;
  return solution;
}

/// Takes the solution from centred and scaled coordinates back to millimetres.
RawFit assemble(std::span<const RawPair> pairs, const Spread& spread, const Solution& solution) {
  const double scale_mm = spread.scale_mm();
  Eigen::Matrix<double, 6, 6> back = Eigen::Matrix<double, 6, 6>::Identity();
  back.bottomRows<2>() << -design(spread.from_center_mm).leftCols<4>(),
      scale_mm * Eigen::Matrix2d::Identity();

  RawFit fit;
  fit.linear << solution.a[0], solution.a[1], solution.a[2], solution.a[3];
  const Eigen::Vector2d center_shift_mm = scale_mm * solution.a.tail<2>();
  fit.translation_mm = spread.to_center_mm + center_shift_mm - fit.linear * spread.from_center_mm;
  const ModelJacobian propagation = back * solution.propagation;
  fit.cov = propagation * propagation.transpose();
  const Eigen::Matrix<double, 6, 6> gain = back * solution.gain;

  fit.gain.resize(6, 2 * static_cast<Eigen::Index>(pairs.size()));
  fit.residuals_mm.reserve(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector2d from_mm = pairs[i].from_mm - spread.from_center_mm;
    const Eigen::Vector2d to_mm = seen_from_center(pairs[i], spread);
    const Eigen::Vector2d whole_mm = to_mm - fit.linear * from_mm - center_shift_mm;
    const Eigen::Vector2d residual_mm = observed_part(whole_mm, pairs[i].axes);
    const Eigen::Matrix2d w = *whitening(pairs[i]);
    fit.residuals_mm.push_back(residual_mm);
    fit.chi_square += (w * residual_mm).squaredNorm();
    fit.gain.middleCols<2>(2 * static_cast<Eigen::Index>(i)) =
        scale_mm * gain * design(from_mm / scale_mm).transpose() * (w.transpose() * w);
  }
  return fit;
}

}  // namespace

RawFitResult fit_raw(std::span<const RawPair> pairs, PanelModel model) {
  const int n_equations = equation_count(pairs);
  if (n_equations < parameter_count(model)) return {std::nullopt, FitFailure::TooFewTargets};
  const Spread spread = spread_of(pairs);
  const std::optional<SquareRoot> system = accumulate(pairs, spread);
  if (!system) return {std::nullopt, FitFailure::BadCovariance};
  std::optional<SquareRoot> structure;
  if (has_slots(pairs)) structure = structure_of(pairs, spread);
  const bool is_determined = structure ? determines(*structure, model) : determines(spread, model);
  if (!is_determined) return {std::nullopt, FitFailure::Degenerate};
  const std::optional<Solution> solution = solve_panel(*system, structure, model);
  if (!solution) return {std::nullopt, FitFailure::Degenerate};
  RawFit fit = assemble(pairs, spread, *solution);
  fit.degrees_of_freedom = n_equations - parameter_count(model);
  return {std::move(fit), FitFailure::TooFewTargets};
}

}  // namespace panelcal::internal
