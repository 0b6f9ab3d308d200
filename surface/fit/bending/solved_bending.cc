// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/bending/solved_bending.h"

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
/// Rounding error of a variance, relative to the terms whose difference it is.
constexpr double kVarianceRounding = 1e-15;

/// Of a Matern kernel.
double exponent_by_distance(BendingKernel kernel) {
  if (kernel == BendingKernel::Matern32) return std::sqrt(3.0);
  return kernel == BendingKernel::Matern52 ? std::sqrt(5.0) : 1;
}

}  // namespace

RelatedPlaces::RelatedPlaces(const Readings& readings,
                             const Eigen::Matrix2Xd& places,
                             Index n_trend)
    : distances_(readings.places.cols(), places.cols()), trends_(n_trend, places.cols()) {
  for (Index j = 0; j < places.cols(); ++j) {
    distances_.col(j) =
        (readings.places.colwise() - places.col(j)).colwise().norm().transpose().array();
    trends_.col(j) = trend_at(places.col(j), n_trend);
  }
}

const Eigen::ArrayXXd& RelatedPlaces::falloff(BendingKernel kernel, double length) {
  const bool is_gaussian = kernel == BendingKernel::Gaussian;
  for (const Falloff& known : falloffs_) {
    int n_halved = 0;
    while (std::ldexp(length, n_halved) < known.length) ++n_halved;
    if (known.kernel != kernel || std::ldexp(length, n_halved) != known.length) continue;
    if (n_halved == 0) return known.values;
    Falloff next{kernel, length, known.values};
    for (int i = 0; i < (is_gaussian ? 2 : 1) * n_halved; ++i) next.values *= next.values;
    return falloffs_.emplace_back(std::move(next)).values;
  }
  const Eigen::ArrayXXd r = distances_ / length;
  Falloff first{kernel, length, {}};
  if (is_gaussian) {
    first.values = (-0.5 * r * r).exp();
  } else {
    first.values = (-exponent_by_distance(kernel) * r).exp();
  }
  return falloffs_.emplace_back(std::move(first)).values;
}

MatrixXd RelatedPlaces::covariances(BendingKernel kernel, double length) {
  switch (kernel) {
    case BendingKernel::None:
      return MatrixXd::Zero(distances_.rows(), distances_.cols());
    case BendingKernel::ThinPlate: {
      const Eigen::ArrayXXd r = distances_ / length;
      // Where r is 0, so is this; what is no number stays none.
      return r * r * (r == 0).select(1, r).log();
    }
    case BendingKernel::Matern12:
    case BendingKernel::Gaussian:
      return falloff(kernel, length);
    case BendingKernel::Matern32: {
      const Eigen::ArrayXXd a = exponent_by_distance(kernel) / length * distances_;
      return a.isInf().select(0, (1 + a) * falloff(kernel, length));
    }
    case BendingKernel::Matern52: {
      const Eigen::ArrayXXd a = exponent_by_distance(kernel) / length * distances_;
      return a.isInf().select(0, (1 + a + a * a / 3) * falloff(kernel, length));
    }
  }
  return {};
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
  // The trend alone predicts a surface that does not bend.
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

VectorXd SolvedBending::heights_mm(RelatedPlaces& places) const {
  VectorXd out = places.trends().transpose() * trend_mm_;
  if (bending_.strength_mm2 > 0)
    out += places.covariances(bending_.kernel, bending_.length).transpose() * weights_;
  return out;
}

std::pair<VectorXd, VectorXd> SolvedBending::at(RelatedPlaces& places) const {
  const MatrixXd c = places.covariances(bending_.kernel, bending_.length);
  const MatrixXd& t = places.trends();
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

MatrixXd SolvedBending::covariance_mm2(RelatedPlaces& places,
                                       const Eigen::Matrix2Xd& reduced) const {
  const MatrixXd c = places.covariances(bending_.kernel, bending_.length);
  const MatrixXd& t = places.trends();
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
