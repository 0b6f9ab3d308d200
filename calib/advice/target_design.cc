// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/target_design.h"

#include <algorithm>
#include <cmath>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/panel/model.h"
#include "calib/panel/system.h"
#include <Eigen/Core>

namespace panelcal {
namespace {

using PointJacobian = Eigen::Matrix<double, 2, 6>;

/// Baarda's delta_0: 0.1 % false alarms, 80 % found, one dimension.
constexpr double kDetection = 4.13;
/// Below this share of a target's noise residuals show nothing of its lie.
constexpr double kBlind = 1e-9;
/// Two lies closer than this (cosine squared of the angle between their residuals) are the same in
/// practice: telling them apart would take some 22 times the smallest lie that is found.
constexpr double kConfusable = 0.998;
/// More targets than this are not held against each other pair by pair.
constexpr std::size_t kMostPairs = 300;

PointJacobian point_jacobian(const Eigen::Vector2d& p, ObservedAxes axes = ObservedAxes::Both) {
  PointJacobian j = internal::design(p);
  if (!observes_x(axes)) j.row(0).setZero();
  if (!observes_y(axes)) j.row(1).setZero();
  return j;
}

/// d coefficients / d parameters at the drawn panel.
internal::ModelJacobian basis(PanelModel model) {
  internal::ModelParameters p = internal::ModelParameters::Zero(parameter_count(model));
  if (model == PanelModel::Similarity) p[0] = 1;
  if (model == PanelModel::Stretch) p[1] = p[2] = 1;
  if (model == PanelModel::Affine) p[0] = p[3] = 1;
  return internal::coefficient_jacobian(model, p);
}

/// Square root of the pseudo-inverse of a symmetric 2 x 2 matrix with eigenvalues 0 to 1.
Eigen::Matrix2d inverse_root(const Eigen::Matrix2d& m) {
  const internal::PlaneEigensystem eigen = internal::plane_eigensystem(m);
  Eigen::Vector2d roots = Eigen::Vector2d::Zero();
  for (int i = 0; i < 2; ++i) {
    if (eigen.values[i] > kBlind) roots[i] = 1 / std::sqrt(eigen.values[i]);
  }
  return eigen.vectors * roots.asDiagonal() * eigen.vectors.transpose();
}

/// Response of a target's own residuals to its own error.
struct Blindness {
  PointJacobian jacobian;
  Eigen::Matrix2d inverse_root = Eigen::Matrix2d::Zero();
  int n_observed = 0;  ///< coordinates
  int n_visible = 0;   ///< directions in which a lie shows
  double least = 0;    ///< share of the lie that shows, in the worst direction, squared
};

Blindness blindness(const DesignTarget& target, const MapCovariance& cov) {
  Blindness out;
  out.jacobian = point_jacobian(target.nominal.in_mm(), target.axes);
  Eigen::Matrix2d identity = Eigen::Matrix2d::Zero();
  identity(0, 0) = observes_x(target.axes) ? 1 : 0;
  identity(1, 1) = observes_y(target.axes) ? 1 : 0;
  out.n_observed = static_cast<int>(identity.trace());
  const Eigen::Matrix2d r = identity - out.jacobian * cov * out.jacobian.transpose();
  const Eigen::Vector2d shares = internal::plane_eigensystem(r).values;
  out.n_visible = static_cast<int>((shares.array() > kBlind).count());
  out.least = out.n_observed == 2 ? shares[0] : shares[1];
  out.inverse_root = inverse_root(r);
  return out;
}

/// Similarity of the errors of two targets: cosines squared of the principal angles, greatest
/// first.
Eigen::Vector2d alikeness(const Blindness& a, const Blindness& b, const MapCovariance& cov) {
  const Eigen::Matrix2d between = -a.jacobian * cov * b.jacobian.transpose();
  const Eigen::Matrix2d white = a.inverse_root * between * b.inverse_root;
  const Eigen::Matrix2d square = white.transpose() * white;
  return internal::plane_eigensystem(square).values.reverse();
}

}  // namespace

namespace internal {

MapCovariance information(const Eigen::Vector2d& p_mm, ObservedAxes axes) {
  const PointJacobian j = point_jacobian(p_mm, axes);
  return j.transpose() * j;
}

MapCovariance covariance_of(const MapCovariance& information,
                            PanelModel model,
                            const MapCovariance& base_cov,
                            double ridge) {
  const ModelJacobian b = basis(model);
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;
  Small normal = b.transpose() * information * b;
  normal.diagonal().array() += ridge;
  const Small inverse = Cholesky(normal).inverse();
  MapCovariance cov = b * inverse * b.transpose();
  if (!base_cov.isZero(0)) {
    // The part of the base's error that the nested fit does not take back.
    const MapCovariance left = MapCovariance::Identity() - cov * information;
    cov += left * base_cov * left.transpose();
  }
  return cov;
}

}  // namespace internal

double greatest_sigma(const Eigen::Matrix2d& cov) {
  const double mean = (cov(0, 0) + cov(1, 1)) / 2;
  const double half = (cov(0, 0) - cov(1, 1)) / 2;
  return std::sqrt(std::max(0.0, mean + std::hypot(half, cov(0, 1))));
}

LeverageMap::Form LeverageMap::form(const MapCovariance& cov, int row, int column) {
  // Row 0 has the coefficients l00 l01 tx, row 1 l10 l11 ty.
  const auto of = [&](int i, int k) {
    const int at_row = i == 2 ? 4 + row : 2 * row + i;
    const int at_column = k == 2 ? 4 + column : 2 * column + k;
    return cov(at_row, at_column);
  };
  Form f;
  f << of(0, 0), of(0, 1) + of(1, 0), of(1, 1), of(0, 2) + of(2, 0), of(1, 2) + of(2, 1), of(2, 2);
  return f;
}

LeverageMap::LeverageMap(const MapCovariance& cov)
    : in_x_(form(cov, 0, 0)), in_y_(form(cov, 1, 1)), mixed_(form(cov, 0, 1)) {
}

Eigen::Matrix2d LeverageMap::covariance(const Position<frame::Nominal>& p) const {
  const double x = p.in_mm().x();
  const double y = p.in_mm().y();
  const auto at = [x, y](const Form& f) {
    return x * (f[0] * x + f[1] * y + f[3]) + y * (f[2] * y + f[4]) + f[5];
  };
  Eigen::Matrix2d cov;
  cov << at(in_x_), at(mixed_), at(mixed_), at(in_y_);
  return cov;
}

double LeverageMap::operator()(const Position<frame::Nominal>& p) const {
  return greatest_sigma(covariance(p));
}

PredictedFitResult predict_fit(std::span<const DesignTarget> targets,
                               PanelModel model,
                               const MapCovariance& base_cov) {
  std::vector<internal::RawPair> pairs;
  pairs.reserve(targets.size());
  for (const DesignTarget& target : targets) {
    const Eigen::Vector2d at_mm = target.nominal.in_mm();
    pairs.push_back({at_mm, at_mm, Eigen::Matrix2d::Identity(), target.axes});
  }
  const internal::RawFitResult result = internal::fit_raw(pairs, model);
  if (!result.fit) return {std::nullopt, result.failure};
  PredictedFit fit{model, result.fit->cov, result.fit->cov, result.fit->degrees_of_freedom};
  if (!base_cov.isZero(0)) {
    MapCovariance left = MapCovariance::Identity();
    for (std::size_t i = 0; i < targets.size(); ++i) {
      left -= result.fit->gain.middleCols<2>(2 * static_cast<Eigen::Index>(i)) *
              point_jacobian(targets[i].nominal.in_mm());
    }
    fit.cov += left * base_cov * left.transpose();
  }
  return {fit, FitFailure::TooFewTargets};
}

std::vector<LieDetection> detect_lies(std::span<const DesignTarget> targets,
                                      const PredictedFit& fit) {
  using Answer = LieDetection::Answer;
  std::vector<Blindness> blind;
  blind.reserve(targets.size());
  for (const DesignTarget& target : targets) blind.push_back(blindness(target, fit.own_cov));
  std::vector<LieDetection> lies(targets.size());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    LieDetection& lie = lies[i];
    if (blind[i].n_visible == 0) continue;
    const bool is_whole = blind[i].n_visible == blind[i].n_observed;
    lie.is_found = is_whole ? Answer::Yes : Answer::InPart;
    if (is_whole) lie.found_from = kDetection / std::sqrt(blind[i].least);
    lie.is_named = lie.is_found;
    if (targets.size() > kMostPairs) continue;
    for (std::size_t j = 0; j < targets.size(); ++j) {
      if (j == i) continue;
      const Eigen::Vector2d alike = alikeness(blind[i], blind[j], fit.own_cov);
      // As many directions as a lie has, or fewer, may look like one of j.
      if (alike[blind[i].n_visible - 1] > kConfusable) {
        lie.is_named = Answer::No;
      } else if (alike[0] > kConfusable) {
        lie.is_named = std::min(lie.is_named, Answer::InPart);
      }
    }
  }
  return lies;
}

LieDetection weakest(std::span<const LieDetection> lies) {
  if (lies.empty()) return {};
  LieDetection out = lies.front();
  for (const LieDetection& lie : lies) {
    out.is_found = std::min(out.is_found, lie.is_found);
    out.is_named = std::min(out.is_named, lie.is_named);
    if (!lie.found_from) out.found_from.reset();
    if (out.found_from && lie.found_from) {
      out.found_from = std::max(*out.found_from, *lie.found_from);
    }
  }
  return out;
}

}  // namespace panelcal
