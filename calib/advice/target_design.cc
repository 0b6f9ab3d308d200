// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/target_design.h"

#include <algorithm>
#include <cmath>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/panel/model.h"
#include "calib/panel/system.h"
#include <Eigen/Core>

namespace panelcal {
namespace internal {

ModelJacobian drawn_jacobian(PanelModel model) {
  ModelParameters p = ModelParameters::Zero(parameter_count(model));
  if (model == PanelModel::Similarity) p[0] = 1;
  if (model == PanelModel::Stretch) p[1] = p[2] = 1;
  if (model == PanelModel::Affine) p[0] = p[3] = 1;
  return coefficient_jacobian(model, p);
}

Eigen::Matrix2d weight(const DesignTarget& target) {
  // Of a covariance that is not positive definite nothing counts; predict_fit refuses it.
  const Eigen::Matrix2d w =
      whitening(RawPair{{}, {}, target.cov, target.axes}).value_or(Eigen::Matrix2d::Zero());
  return w.transpose() * w;
}

MapCovariance information(const Eigen::Vector2d& p, const DesignTarget& target) {
  const Eigen::Matrix<double, 2, 6> j = design(p);
  return j.transpose() * weight(target) * j;
}

MapCovariance covariance_of(const MapCovariance& information,
                            PanelModel model,
                            const MapCovariance& base_cov,
                            double ridge) {
  const ModelJacobian b = drawn_jacobian(model);
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
    pairs.push_back({at_mm, at_mm, target.cov, target.axes});
  }
  const internal::RawFitResult result = internal::fit_raw(pairs, model);
  if (!result.fit) return {std::nullopt, result.failure};
  PredictedFit fit{model, result.fit->cov, result.fit->cov, result.fit->degrees_of_freedom};
  if (!base_cov.isZero(0)) {
    MapCovariance left = MapCovariance::Identity();
    for (std::size_t i = 0; i < targets.size(); ++i) {
      left -= result.fit->gain.middleCols<2>(2 * static_cast<Eigen::Index>(i)) *
              internal::design(targets[i].nominal.in_mm());
    }
    fit.cov += left * base_cov * left.transpose();
  }
  return {fit, FitFailure::TooFewTargets};
}

}  // namespace panelcal
