// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/smooth_panel.h"

#include <cmath>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/panel/smoothing.h"
#include "calib/panel/system.h"
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Bendings weaker than this share of what the targets' places allow are rounding.
constexpr double kNoBending = 1e-12;
/// As in model_choice.cc: 1 - leverage of a target that the others cannot do without.
constexpr double kNoPanelResidual = 1e-10;

/// Strengths that hardly count need not predict a target that is left out: the strongest cannot.
constexpr double kNoWeight = 1e-6;

/// r^2 log r, by the square of r.
double plate(double squared) {
  return squared > 0 ? 0.5 * squared * std::log(squared) : 0;
}

/// b(p) of RawSmooth, of a scaled place.
SmoothBasis basis_of(const Eigen::Matrix2Xd& knots, const Eigen::Vector2d& p) {
  const Index n = knots.cols();
  SmoothBasis b(n + 3);
  for (Index i = 0; i < n; ++i) b[i] = plate((p - knots.col(i)).squaredNorm());
  b[n] = 1;
  b[n + 1] = p.x();
  b[n + 2] = p.y();
  return b;
}

/// The observed coordinates as whitened equations, y = B (A p + t + f(p)) + e with e ~ N(0, 1).
struct Equations {
  MatrixXd b;                ///< equations x coordinates (x0 y0 x1 ..)
  VectorXd y;                ///< from the centre
  std::vector<Index> first;  ///< equation of each target, and their number
};

std::optional<Equations> equations_of(std::span<const RawPair> pairs, const Spread& spread) {
  Equations out;
  const auto n = static_cast<Index>(pairs.size());
  out.b = MatrixXd::Zero(equation_count(pairs), 2 * n);
  out.y.resize(out.b.rows());
  Index row = 0;
  for (Index i = 0; i < n; ++i) {
    const RawPair& pair = pairs[static_cast<std::size_t>(i)];
    const std::optional<Eigen::Matrix2d> w = whitening(pair);
    if (!w) return std::nullopt;
    const Eigen::Vector2d seen = *w * seen_from_center(pair, spread);
    out.first.push_back(row);
    for (int axis = 0; axis < 2; ++axis) {
      if (!(axis == 0 ? observes_x(pair.axes) : observes_y(pair.axes))) continue;
      out.b.block<1, 2>(row, 2 * i) = w->row(axis);
      out.y[row++] = seen[axis];
    }
  }
  out.first.push_back(row);
  return out;
}

/// Each number twice: once for x, once for y.
MatrixXd for_both_axes(const MatrixXd& m) {
  MatrixXd out = MatrixXd::Zero(2 * m.rows(), 2 * m.cols());
  for (Index i = 0; i < m.rows(); ++i) {
    for (Index j = 0; j < m.cols(); ++j) out(2 * i, 2 * j) = out(2 * i + 1, 2 * j + 1) = m(i, j);
  }
  return out;
}

/// The equations split into what an affine map takes up and the rest, in coordinates of the rest
/// where noise and bending are both diagonal.
struct Split {
  MatrixXd plates;  ///< covariance of the bendings in the equations, for strength 1
  MatrixXd lift;    ///< L: the affine map of coefficients (1, x, y; x and y by turns) is L^T y
  MatrixXd rest;    ///< V: z = V^T y ~ N(0, 1 + s d)
  VectorXd d;
  VectorXd z;
};

std::optional<Split> split(const Equations& equations, const Eigen::Matrix2Xd& knots) {
  const Index n = knots.cols();
  MatrixXd affine(n, 3);
  affine << VectorXd::Ones(n), knots.transpose();
  MatrixXd phi(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) phi(i, j) = plate((knots.col(i) - knots.col(j)).squaredNorm());
  }
  Split out;
  out.plates = equations.b * for_both_axes(phi) * equations.b.transpose();
  const Index n_equations = equations.y.size();
  const OrthogonalTriangular qr(equations.b * for_both_axes(affine));
  const MatrixXd q = qr.q();
  const MatrixXd r = qr.r();
  out.lift = q.leftCols(6) *
             r.transpose().triangularView<Eigen::Lower>().solve(MatrixXd(MatrixXd::Identity(6, 6)));
  const MatrixXd complement = q.rightCols(n_equations - 6);
  const Eigensystem modes = eigensystem(complement.transpose() * out.plates * complement);
  if (!modes.has_converged) return std::nullopt;
  const double possible = (equations.b * equations.b.transpose()).trace();
  const VectorXd& d = modes.values;
  if (!(d.maxCoeff() > kNoBending * possible)) return std::nullopt;
  // Rounding is no mode that bends.
  out.d = (d.array() > kNoBending * possible).select(d, 0);
  out.rest = complement * modes.vectors;
  out.z = out.rest.transpose() * equations.y;
  return out;
}

/// The weights of b(p), x and y by turns.
VectorXd mean_weights(const Equations& equations, const Split& split, const Smoothing& smoothing) {
  // By strength: the plates' weights are s B^T V (1 - shrinkage) z.
  const MatrixXd kept = (1 - smoothing.shrinkage.array()).matrix();
  const VectorXd pull =
      split.z.cwiseProduct(kept * smoothing.weight.cwiseProduct(smoothing.strength));
  const VectorXd alpha = split.rest * pull;
  VectorXd weights(equations.b.cols() + 6);
  weights << equations.b.transpose() * alpha,
      split.lift.transpose() * (equations.y - split.plates * alpha);
  return weights;
}

/// d mean_weights / d measured, the smoothing held fast. A shift of all targets alike comes out as
/// such, so it does not matter that the centre is theirs.
MatrixXd influence(const Equations& equations, const Split& split, const Smoothing& smoothing) {
  const MatrixXd kept = (1 - smoothing.shrinkage.array()).matrix();
  const VectorXd pull = kept * smoothing.weight.cwiseProduct(smoothing.strength);
  const MatrixXd alpha = split.rest * pull.asDiagonal() * split.rest.transpose() * equations.b;
  MatrixXd out(equations.b.cols() + 6, equations.b.cols());
  out << equations.b.transpose() * alpha,
      split.lift.transpose() * (equations.b - split.plates * alpha);
  return out;
}

/// Parts of the covariance of f(p), as quadratic forms in b(p). With u the affine estimate at p,
/// whose own errors are `noise`, and h = f(p) - u B f what it misses, h given the rest's z has the
/// variance s kappa - s^2 g^T (1 + s d)^-1 g; and from one strength to another its mean moves.
struct CovarianceParts {
  MatrixXd noise;
  MatrixXd kappa;
  MatrixXd g;      ///< h by what the rest shows
  MatrixXd means;  ///< of h by strength, from their own mean, as multiples of g
  MatrixXd known;  ///< s^2 / (1 + s d) by strength
};

CovarianceParts covariance_parts(const Equations& equations,
                                 const Split& split,
                                 const Smoothing& smoothing) {
  const Index n = equations.b.cols();
  const Index m = split.z.size();
  const MatrixXd plates_of_lift = split.plates * split.lift;
  CovarianceParts out;
  out.g.resize(m, n + 6);
  out.g << split.rest.transpose() * equations.b, -split.rest.transpose() * plates_of_lift;
  out.kappa = MatrixXd::Zero(n + 6, n + 6);
  out.kappa.topRightCorner(n, 6) = -equations.b.transpose() * split.lift;
  out.kappa.bottomLeftCorner(6, n) = out.kappa.topRightCorner(n, 6).transpose();
  out.kappa.bottomRightCorner(6, 6) = split.lift.transpose() * plates_of_lift;
  out.noise = MatrixXd::Zero(n + 6, n + 6);
  out.noise.bottomRightCorner(6, 6) = split.lift.transpose() * split.lift;
  out.means.resize(m, smoothing.strength.size());
  out.known.resize(m, smoothing.strength.size());
  for (Index k = 0; k < out.means.cols(); ++k) {
    const double s = smoothing.strength[k];
    const VectorXd kept = (1 - smoothing.shrinkage.col(k).array()).matrix();
    out.means.col(k) = s * kept.cwiseProduct(split.z);
    out.known.col(k) = s * s * kept;
  }
  out.means.colwise() -= VectorXd(out.means * smoothing.weight);
  return out;
}

/// How much the bending's covariance has to grow, in the geometric mean over a grid of the targets'
/// rectangle and a quarter of its sides around it.
double mean_growth(const CovarianceParts& parts,
                   const Smoothing& smoothing,
                   const Eigen::Matrix2Xd& knots) {
  constexpr int kSteps = 4;
  const Eigen::Vector2d low = knots.rowwise().minCoeff();
  const Eigen::Vector2d sides = knots.rowwise().maxCoeff() - low;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const Eigen::Vector2d share(static_cast<double>(i) / kSteps, static_cast<double>(j) / kSteps);
      const Eigen::Vector2d p = low + (1.5 * share.array() - 0.25).matrix().cwiseProduct(sides);
      const MatrixXd b = for_both_axes(basis_of(knots, p));
      const MatrixXd g = parts.g * b;
      const Eigen::Matrix2d kappa = b.transpose() * parts.kappa * b;
      std::vector<Eigen::Matrix2d> bent;
      for (Index k = 0; k < smoothing.weight.size(); ++k) {
        const Eigen::Vector2d moved = g.transpose() * parts.means.col(k);
        bent.emplace_back(smoothing.strength[k] * kappa + moved * moved.transpose() -
                          propagated_diagonal(g.transpose(), parts.known.col(k)));
      }
      const Eigen::Matrix2d noise = b.transpose() * parts.noise * b;
      sum += std::log(growth_to_95_percent(noise, bent, smoothing.weight));
    }
  }
  return std::exp(sum / ((kSteps + 1) * (kSteps + 1)));
}

/// The covariance of f(p) as a quadratic form in b(p).
MatrixXd mean_covariance(const CovarianceParts& parts,
                         const Smoothing& smoothing,
                         const Eigen::Matrix2Xd& knots) {
  MatrixXd middle = propagated_diagonal(parts.means, smoothing.weight);
  middle.diagonal() -= parts.known * smoothing.weight;
  const MatrixXd bent = smoothing.weight.dot(smoothing.strength) * parts.kappa +
                        parts.g.transpose() * middle * parts.g;
  return parts.noise + mean_growth(parts, smoothing, knots) * bent;
}

std::optional<double> left_out_rms(std::span<const RawPair> pairs,
                                   const Equations& equations,
                                   const Split& split,
                                   const Smoothing& smoothing) {
  double sum_mm2 = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Index row = equations.first[i];
    const Index n_rows = equations.first[i + 1] - row;
    const MatrixXd v = split.rest.middleRows(row, n_rows);
    Eigen::Vector2d white = Eigen::Vector2d::Zero();
    for (Index k = 0; k < smoothing.weight.size(); ++k) {
      if (smoothing.weight[k] < kNoWeight) continue;
      const VectorXd kept = (1 - smoothing.shrinkage.col(k).array()).matrix();
      // A target has two rows, a slot one.
      Eigen::Matrix2d left = Eigen::Matrix2d::Identity();
      left.topLeftCorner(n_rows, n_rows) = propagated_diagonal(v, kept);
      if (!(std::abs(left.determinant()) > kNoPanelResidual)) return std::nullopt;
      Eigen::Vector2d seen = Eigen::Vector2d::Zero();
      seen.head(n_rows) = v * kept.cwiseProduct(split.z);
      white += smoothing.weight[k] * (left.inverse() * seen);
    }
    if (n_rows == 2) white = whitening(pairs[i])->inverse() * white;
    if (n_rows == 1) white /= whitening(pairs[i])->sum();
    sum_mm2 += white.squaredNorm();
  }
  return std::sqrt(sum_mm2 / static_cast<double>(pairs.size()));
}

}  // namespace

RawSmooth::Basis RawSmooth::basis(const Eigen::Vector2d& p) const {
  return basis_of(knots, p);
}

Eigen::Vector2d RawSmooth::place_mm(const Basis& b) const {
  Eigen::Vector2d sum_mm = to_center_mm;
  for (Index k = 0; k < b.size(); ++k) sum_mm += b[k] * weights.col(k);
  return sum_mm;
}

Eigen::Vector2d RawSmooth::map_mm(const Eigen::Vector2d& p_mm) const {
  return place_mm(basis_at(p_mm));
}

Eigen::Matrix2d RawSmooth::jacobian(const Eigen::Vector2d& p_mm) const {
  const Eigen::Vector2d p = (p_mm - center_mm) / scale_mm;
  const Index n = knots.cols();
  Eigen::Matrix2d out = weights.rightCols<2>();
  for (Index i = 0; i < n; ++i) {
    const Eigen::Vector2d from_knot = p - knots.col(i);
    const double squared = from_knot.squaredNorm();
    if (!(squared > 0)) continue;
    out += (std::log(squared) + 1) * weights.col(i) * from_knot.transpose();
  }
  return out / scale_mm;
}

Eigen::Matrix2d RawSmooth::cov_mm2(const Eigen::Vector2d& p_mm) const {
  return cov(basis_at(p_mm));
}

Eigen::Matrix2d RawSmooth::by_target(const Basis& b, std::size_t i_target) const {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (Index k = 0; k < b.size(); ++k) {
    sum += b[k] * by_measured.block<2, 2>(2 * k, 2 * static_cast<Index>(i_target));
  }
  return sum;
}

Eigen::Matrix2Xd RawSmooth::weights_of(const Eigen::Matrix2d& linear,
                                       const Eigen::Vector2d& translation_mm) const {
  Eigen::Matrix2Xd out = Eigen::Matrix2Xd::Zero(2, weights.cols());
  out.rightCols<2>() = linear * scale_mm;
  out.col(weights.cols() - 3) = linear * center_mm + translation_mm - to_center_mm;
  return out;
}

CovarianceForm CovarianceForm::of_weights(const Eigen::MatrixXd& cov) {
  const Index n = cov.rows() / 2;
  const auto of_axes = [&cov, n](Index i, Index j) -> MatrixXd {
    return cov(Eigen::seqN(i, n, 2), Eigen::seqN(j, n, 2));
  };
  return {of_axes(0, 0), 0.5 * (of_axes(0, 1) + of_axes(1, 0)), of_axes(1, 1)};
}

void CovarianceForm::operator+=(const CovarianceForm& other) {
  xx += other.xx;
  xy += other.xy;
  yy += other.yy;
}

Eigen::Matrix2d CovarianceForm::operator()(const SmoothBasis& b) const {
  // No product of a matrix and a vector: that would allocate.
  double sum_xx = 0, sum_xy = 0, sum_yy = 0;
  for (Index j = 0; j < b.size(); ++j) {
    sum_xx += b[j] * xx.col(j).dot(b);
    sum_xy += b[j] * xy.col(j).dot(b);
    sum_yy += b[j] * yy.col(j).dot(b);
  }
  Eigen::Matrix2d out;
  out << sum_xx, sum_xy, sum_xy, sum_yy;
  return out;
}

bool is_unfolded(const RawSmooth& smooth, std::span<const RawPair> pairs) {
  constexpr int kSteps = 32;
  Eigen::Vector2d low_mm = pairs.front().from_mm;
  Eigen::Vector2d high_mm = low_mm;
  for (const RawPair& pair : pairs) {
    low_mm = low_mm.cwiseMin(pair.from_mm);
    high_mm = high_mm.cwiseMax(pair.from_mm);
    if (!(smooth.jacobian(pair.from_mm).determinant() > 0)) return false;
  }
  const Eigen::Vector2d around_mm = 0.25 * (high_mm - low_mm);
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const Eigen::Vector2d share(static_cast<double>(i) / kSteps, static_cast<double>(j) / kSteps);
      const Eigen::Vector2d p_mm =
          low_mm - around_mm + share.cwiseProduct(high_mm - low_mm + 2 * around_mm);
      if (!(smooth.jacobian(p_mm).determinant() > 0)) return false;
    }
  }
  return true;
}

std::optional<RawSmooth> fit_smooth_raw(std::span<const RawPair> pairs) {
  if (pairs.size() < kLeastSmoothTargets || pairs.size() > kMostSmoothTargets) return std::nullopt;
  if (!fit_raw(pairs, PanelModel::Affine).fit || equation_count(pairs) < 7) return std::nullopt;
  const Spread spread = spread_of(pairs);
  const std::optional<Equations> equations = equations_of(pairs, spread);
  if (!equations) return std::nullopt;

  RawSmooth fit;
  const auto n = static_cast<Index>(pairs.size());
  fit.center_mm = spread.from_center_mm;
  fit.to_center_mm = spread.to_center_mm;
  fit.scale_mm = spread.scale_mm();
  fit.knots.resize(2, n);
  for (Index i = 0; i < n; ++i) {
    fit.knots.col(i) = (pairs[static_cast<std::size_t>(i)].from_mm - fit.center_mm) / fit.scale_mm;
  }
  const std::optional<Split> parts = split(*equations, fit.knots);
  if (!parts) return std::nullopt;
  const Smoothing smoothing = weigh_strengths(parts->z, parts->d);

  const VectorXd weights = mean_weights(*equations, *parts, smoothing);
  fit.weights = weights.reshaped(2, n + 3);
  const CovarianceParts of_cov = covariance_parts(*equations, *parts, smoothing);
  const MatrixXd cov = mean_covariance(of_cov, smoothing, fit.knots);
  fit.cov = CovarianceForm::of_weights(cov);
  fit.choice = CovarianceForm::of_weights(MatrixXd::Zero(cov.rows(), cov.cols()));
  fit.misfit = fit.choice;
  fit.by_measured = influence(*equations, *parts, smoothing);

  const VectorXd squared = parts->z.cwiseAbs2();
  const VectorXd shrinkage = smoothing.mean_shrinkage();
  fit.chi_square = squared.dot((1 - shrinkage.array()).square().matrix());
  fit.parameters = 6 + shrinkage.sum() + squared.dot(smoothing.shrinkage_variance());
  fit.left_out_rms_mm = left_out_rms(pairs, *equations, *parts, smoothing);
  for (const RawPair& pair : pairs) {
    const Eigen::Vector2d miss_mm = pair.to_mm - fit.map_mm(pair.from_mm);
    fit.residuals_mm.push_back(observed_part(miss_mm, pair.axes));
  }
  const bool is_finite = fit.weights.allFinite() && cov.allFinite();
  return is_finite ? std::optional(std::move(fit)) : std::nullopt;
}

}  // namespace panelcal::internal
