// SPDX-License-Identifier: Apache-2.0
#include "panelcal/calib/panel_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "panelcal/calib/panel_model.h"

// The work is done once per target on a square-root form: min |factor a - target|^2 over the six
// affine coefficients a. Each model then only searches its own parameters in six dimensions,
// whatever the number of targets. The square-root form loses half the digits a normal matrix
// would.
namespace panelcal::internal {
namespace {

/// Program coordinates step by 0.1 um at best: targets nearer than this are one and the same.
constexpr double kCoincident_mm = 1e-6;
/// Least ratio of the targets' spreads across and along, below which they lie on one line.
constexpr double kCollinear = 1e-6;
/// Correlation of a measurement's x and y errors so near to 1 that its covariance is no ellipse.
constexpr double kSingularCovariance = 1e-12;
/// Standard deviations outside this range are no measurement's; inside it no square overflows.
constexpr double kLeastSigma_mm = 1e-12;
constexpr double kGreatestSigma_mm = 1e12;
/// Least curvature of the cost, relative to Gauss-Newton's, that Newton's method is trusted with.
/// It is 1 for exact data and near it while residuals are small against the targets' distances.
constexpr double kLeastCurvature = 0.1;
constexpr int kMaxIterations = 50;

/// Where the targets lie; fits are done in (p - center) / scale.
struct Spread {
  Eigen::Vector2d from_center_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_center_mm = Eigen::Vector2d::Zero();
  double along_mm = 0;   ///< r.m.s. distance from the centre along the longest direction
  double across_mm = 0;  ///< and across it
  double scale_mm() const { return along_mm > kCoincident_mm ? along_mm : 1.0; }
};

struct SquareRoot {
  Eigen::Matrix<double, 6, 7> rows = Eigen::Matrix<double, 6, 7>::Zero();
  auto factor() const { return rows.leftCols<6>(); }
  auto target() const { return rows.col(6); }
  double cost(const Coefficients& a) const { return (factor() * a - target()).squaredNorm(); }
};

/// The solution, with the square root of its covariance: cov = propagation propagation^T and
/// d coefficients = gain (d right-hand side of the normal equations).
struct Solution {
  Coefficients a;
  ModelJacobian propagation;
  Eigen::Matrix<double, 6, 6> gain;
};

Spread spread_of(std::span<const RawPair> pairs) {
  Spread s;
  for (const RawPair& pair : pairs) {
    s.from_center_mm += pair.from_mm;
    s.to_center_mm += pair.to_mm;
  }
  const auto n = static_cast<double>(pairs.size());
  s.from_center_mm /= n;
  s.to_center_mm /= n;
  double xx = 0, xy = 0, yy = 0;
  for (const RawPair& pair : pairs) {
    const Eigen::Vector2d d = pair.from_mm - s.from_center_mm;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    yy += d.y() * d.y();
  }
  const double half_trace = 0.5 * (xx + yy);
  const double largest = half_trace + std::hypot(0.5 * (xx - yy), xy);
  s.along_mm = std::sqrt(largest / n);
  const double determinant = std::max(0.0, xx * yy - xy * xy);
  s.across_mm = largest > 0 ? std::sqrt(determinant / largest / n) : 0;
  return s;
}

bool determines(const Spread& s, PanelModel model) {
  if (model == PanelModel::Offset) return true;
  if (!(s.along_mm > kCoincident_mm)) return false;
  if (model == PanelModel::Rigid || model == PanelModel::Similarity) return true;
  return s.across_mm > kCollinear * s.along_mm;
}

/// W with W^T W = cov^-1, lower triangular; empty if cov is no covariance.
std::optional<Eigen::Matrix2d> whitening(const Eigen::Matrix2d& cov) {
  const double xx = cov(0, 0);
  const double yy = cov(1, 1);
  const double xy = 0.5 * (cov(0, 1) + cov(1, 0));
  if (!cov.allFinite() || !(xx > 0) || !(yy > 0)) return std::nullopt;
  if (std::abs(cov(0, 1) - cov(1, 0)) > 1e-9 * std::sqrt(xx) * std::sqrt(yy)) return std::nullopt;
  const double sigma_x = std::sqrt(xx);
  const double slope = xy / xx;
  const double rest = yy - slope * xy;
  if (!(rest > kSingularCovariance * yy)) return std::nullopt;
  const double sigma_rest = std::sqrt(rest);
  for (const double sigma : {sigma_x, sigma_rest}) {
    if (!(sigma >= kLeastSigma_mm && sigma <= kGreatestSigma_mm)) return std::nullopt;
  }
  Eigen::Matrix2d w;
  w << 1 / sigma_x, 0, -slope / sigma_rest, 1 / sigma_rest;
  return w;
}

/// The two rows d(point) / d(coefficients) of a target.
Eigen::Matrix<double, 2, 6> design(const Eigen::Vector2d& from) {
  Eigen::Matrix<double, 2, 6> d;
  d << from.x(), from.y(), 0, 0, 1, 0, 0, 0, from.x(), from.y(), 0, 1;
  return d;
}

/// Rotates one more equation into the triangular factor (Givens).
void absorb(SquareRoot& system, Eigen::Matrix<double, 1, 7> row) {
  for (int k = 0; k < 6; ++k) {
    if (row[k] == 0) continue;
    const double pivot = system.rows(k, k);
    const double length = std::sqrt(pivot * pivot + row[k] * row[k]);
    const double c = pivot / length;
    const double s = row[k] / length;
    for (int j = k; j < 7; ++j) {
      const double upper = system.rows(k, j);
      system.rows(k, j) = c * upper + s * row[j];
      row[j] = c * row[j] - s * upper;
    }
  }
}

/// Empty if a covariance is bad or a number is not finite.
std::optional<SquareRoot> accumulate(std::span<const RawPair> pairs, const Spread& spread) {
  SquareRoot system;
  for (const RawPair& pair : pairs) {
    const std::optional<Eigen::Matrix2d> w = whitening(pair.cov_mm2);
    if (!w) return std::nullopt;
    Eigen::Matrix<double, 2, 7> rows;
    rows << design((pair.from_mm - spread.from_center_mm) / spread.scale_mm()),
        (pair.to_mm - spread.to_center_mm) / spread.scale_mm();
    const Eigen::Matrix<double, 2, 7> white = spread.scale_mm() * *w * rows;
    absorb(system, white.row(0));
    absorb(system, white.row(1));
  }
  if (!system.rows.allFinite()) return std::nullopt;
  return system;
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
  if (Eigen::LLT<ModelHessian>(out.curvature - least).info() != Eigen::Success) {
    out.curvature.setIdentity();
  }
  return out;
}

ModelParameters newton_step(const Linearised& at) {
  return at.parameters_from_white * at.curvature.llt().solve(at.descent);
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

std::optional<ModelParameters> minimise(const SquareRoot& system, PanelModel model) {
  const PanelModel first = start_model(model);
  ModelParameters parameters = ModelParameters::Zero(parameter_count(first));
  const std::optional<Linearised> linear = linearise(system, first, parameters);
  if (!linear) return std::nullopt;
  parameters += newton_step(*linear);
  if (first == model) return parameters;

  parameters = start_parameters(model, coefficients(first, parameters));
  double last_length = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMaxIterations; ++i) {
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

std::optional<Solution> solve(const SquareRoot& system, PanelModel model) {
  const std::optional<ModelParameters> parameters = minimise(system, model);
  if (!parameters) return std::nullopt;
  const std::optional<Linearised> at = linearise(system, model, *parameters);
  if (!at) return std::nullopt;
  Solution solution;
  solution.a = coefficients(model, *parameters);
  const ModelJacobian coefficients_from_white =
      coefficient_jacobian(model, *parameters) * at->parameters_from_white;
  const ModelHessian inverse = at->curvature.llt().solve(
      ModelHessian(ModelHessian::Identity(at->curvature.rows(), at->curvature.cols())));
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
    const Eigen::Vector2d to_mm = pairs[i].to_mm - spread.to_center_mm;
    const Eigen::Vector2d residual_mm = to_mm - fit.linear * from_mm - center_shift_mm;
    const Eigen::Matrix2d w = *whitening(pairs[i].cov_mm2);
    fit.residuals_mm.push_back(residual_mm);
    fit.chi_square += (w * residual_mm).squaredNorm();
    fit.gain.middleCols<2>(2 * static_cast<Eigen::Index>(i)) =
        scale_mm * gain * design(from_mm / scale_mm).transpose() * (w.transpose() * w);
  }
  return fit;
}

}  // namespace

RawFitResult fit_raw(std::span<const RawPair> pairs, PanelModel model) {
  const int n_equations = 2 * static_cast<int>(pairs.size());
  if (n_equations < parameter_count(model)) return {std::nullopt, FitFailure::TooFewTargets};
  const Spread spread = spread_of(pairs);
  const std::optional<SquareRoot> system = accumulate(pairs, spread);
  if (!system) return {std::nullopt, FitFailure::BadCovariance};
  if (!determines(spread, model)) return {std::nullopt, FitFailure::Degenerate};
  const std::optional<Solution> solution = solve(*system, model);
  if (!solution) return {std::nullopt, FitFailure::Degenerate};
  RawFit fit = assemble(pairs, spread, *solution);
  fit.degrees_of_freedom = n_equations - parameter_count(model);
  return {std::move(fit), FitFailure::TooFewTargets};
}

}  // namespace panelcal::internal
