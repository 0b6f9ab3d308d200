// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/solved_bending.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace panelcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A probe whose left-out weight is less, by what it would be alone, is predicted by nothing.
constexpr double kUnforetold = 1e-10;
/// What rounding makes of a variance, by the terms that it is the difference of.
constexpr double kVarianceRounding = 1e-15;

}  // namespace

RelatedPlaces::RelatedPlaces(const Readings& readings,
                             const Eigen::Matrix2Xd& places,
                             Index n_trend)
    : distances(readings.places.cols(), places.cols()), trends(n_trend, places.cols()) {
  for (Index j = 0; j < places.cols(); ++j) {
    distances.col(j) =
        (readings.places.colwise() - places.col(j)).colwise().norm().transpose().array();
    trends.col(j) = trend_at(places.col(j), n_trend);
  }
}

SolvedBending::SolvedBending(const Bending& bending,
                             const Readings& readings,
                             const BendingLikelihood& likelihood,
                             Noise noise)
    : bending_(bending), trend_root_(likelihood.trend_root()) {
  const MatrixXd covariance = likelihood.covariance(bending.kernel, bending.length);
  const bool bends = bending.strength_mm2 > 0;
  MatrixXd root =
      likelihood.contrasts().transpose() * readings.sigmas_mm.cwiseInverse().asDiagonal();
  if (bends) {
    MatrixXd noise_and_bending = bending.strength_mm2 * likelihood.contrast_covariance(covariance);
    noise_and_bending.diagonal().array() += 1;
    // In place: of many probes each matrix is large.
    const Eigen::LLT<Eigen::Ref<MatrixXd>> decomposed(noise_and_bending);
    decomposed.matrixL().solveInPlace(root);
  }
  const MatrixXd& lift = likelihood.trend_of_heights();
  const VectorXd& y = readings.heights_mm;
  const VectorXd residual_weights = root.transpose() * (root * y);
  if (noise == Noise::Learned) {
    bending_.noise_factor = likelihood.noise_factor(y.dot(residual_weights));
  }
  weights_ = bending.strength_mm2 * residual_weights;
  trend_mm_ = lift * (y - covariance * weights_);
  const MatrixXd bending_of_trend = covariance * lift.transpose();
  trend_bending_ = lift * bending_of_trend;
  leave_out(readings.sigmas_mm, root, residual_weights);
  // What does not bend is predicted by the trend alone.
  if (bends) {
    root *= bending.strength_mm2;
  } else {
    root.resize(0, y.size());
  }
  root_of_trend_ = root * bending_of_trend;
  onto_.resize(root.rows() + lift.rows(), y.size());
  onto_ << root, lift;
}

void SolvedBending::leave_out(const VectorXd& sigmas_mm,
                              const MatrixXd& root,
                              const VectorXd& residual_weights) {
  for (Index i = 0; i < residual_weights.size(); ++i) {
    LeftOutReading out;
    const double precision = root.col(i).squaredNorm();
    const double alone = 1 / (sigmas_mm[i] * sigmas_mm[i]);
    if (precision > kUnforetold * alone) {
      out.is_predicted = true;
      out.deviation_mm = residual_weights[i] / precision;
      out.sigma_mm = noise_factor() / std::sqrt(precision);
    }
    left_out_.push_back(out);
  }
}

MatrixXd SolvedBending::covariances(const RelatedPlaces& places) const {
  return bending_covariance(bending_.kernel, places.distances / bending_.length);
}

VectorXd SolvedBending::heights_mm(const RelatedPlaces& places) const {
  VectorXd out = places.trends.transpose() * trend_mm_;
  if (bending_.strength_mm2 > 0) out += covariances(places).transpose() * weights_;
  return out;
}

std::pair<VectorXd, VectorXd> SolvedBending::at(const RelatedPlaces& places) const {
  const MatrixXd c = covariances(places);
  const MatrixXd& t = places.trends;
  const Index n_trend = t.rows();
  const MatrixXd by_contrasts = onto_ * c;
  const Index n_contrasts = onto_.rows() - n_trend;
  const MatrixXd predicted = by_contrasts.topRows(n_contrasts) - root_of_trend_ * t;
  const MatrixXd missed = trend_bending_ * t - 2 * by_contrasts.bottomRows(n_trend);
  const MatrixXd trend = trend_root_.transpose() * t;
  const double itself = bending_covariance(bending_.kernel, 0);
  const double noise_variance = noise_factor() * noise_factor();
  VectorXd variances(c.cols());
  for (Index j = 0; j < c.cols(); ++j) {
    const double bent = bending_.strength_mm2 * (itself + t.col(j).dot(missed.col(j)));
    const double tilted = trend.col(j).squaredNorm();
    const double known = predicted.col(j).squaredNorm();
    // Far away they cancel, and what is left of them is rounding. In this order what is no number
    // stays none: nothing is known there, rather than all.
    const double least = kVarianceRounding * (std::abs(bent) + tilted + known);
    variances[j] = noise_variance * std::max(bent + tilted - known, least);
  }
  return {t.transpose() * trend_mm_ + c.transpose() * weights_, std::move(variances)};
}

MatrixXd SolvedBending::covariance_mm2(const RelatedPlaces& places,
                                       const Eigen::Matrix2Xd& reduced) const {
  const MatrixXd c = covariances(places);
  const MatrixXd& t = places.trends;
  const Index n_places = c.cols();
  MatrixXd bent(n_places, n_places);
  for (Index j = 0; j < n_places; ++j) {
    for (Index i = 0; i <= j; ++i) {
      const double r = (reduced.col(i) - reduced.col(j)).norm() / bending_.length;
      bent(i, j) = bent(j, i) = bending_covariance(bending_.kernel, r);
    }
  }
  const MatrixXd by_contrasts = onto_ * c;
  const MatrixXd predicted = by_contrasts.topRows(onto_.rows() - t.rows()) - root_of_trend_ * t;
  const MatrixXd crossed = t.transpose() * by_contrasts.bottomRows(t.rows());
  const MatrixXd trend = trend_root_.transpose() * t;
  bent += t.transpose() * trend_bending_ * t - crossed - crossed.transpose();
  bent =
      bending_.strength_mm2 * bent + trend.transpose() * trend - predicted.transpose() * predicted;
  // Products round to either side of the diagonal differently.
  return 0.5 * noise_factor() * noise_factor() * (bent + bent.transpose());
}

}  // namespace panelcal::internal
