// SPDX-License-Identifier: Apache-2.0
#include "surface/plan/probe_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/base/statistics/linear_algebra.h"
#include "surface/fit/bending/bending_likelihood.h"
#include "surface/fit/fit.h"

namespace panelcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using SearchPlaces = HeightBelief::Places;

/// The trend's coefficients are unknown by so much: more than any panel bends, little enough for
/// the digits of a double.
constexpr double kTrendSigma_mm = 10;
/// Sigmas of the search and of the fit differ by rounding and by how unknown the trend is.
constexpr double kSameSigma = 1e-4;
/// A move that gains less is not made.
constexpr double kLeastGain = 1e-3;

}  // namespace

HeightBelief::HeightBelief(const ProbePlanRequest& request) : request_(request) {
  Eigen::Vector2d low_mm = request.places.front().in_mm(), high_mm = low_mm;
  for (const SearchPlaces* all : {&request.places, &request.candidates}) {
    for (const auto& place : *all) {
      low_mm = low_mm.cwiseMin(place.in_mm());
      high_mm = high_mm.cwiseMax(place.in_mm());
    }
  }
  center_mm_ = 0.5 * (low_mm + high_mm);
  scale_mm_ = std::max(1e-3, 0.5 * (high_mm - low_mm).norm());
}

MatrixXd HeightBelief::operator()(const SearchPlaces& a, const SearchPlaces& b) const {
  MatrixXd out = kTrendSigma_mm * kTrendSigma_mm * trends(a).transpose() * trends(b);
  const double variance_mm2 = request_.amplitude.in_mm() * request_.amplitude.in_mm();
  if (!(variance_mm2 > 0)) return out;
  for (Index j = 0; j < out.cols(); ++j) {
    for (Index i = 0; i < out.rows(); ++i) {
      const auto apart = a[static_cast<std::size_t>(i)] - b[static_cast<std::size_t>(j)];
      const double r = apart.in_mm().norm() / request_.length.in_mm();
      out(i, j) += variance_mm2 * bending_covariance(request_.kernel, r);
    }
  }
  return out;
}

VectorXd HeightBelief::variances_mm2(const SearchPlaces& places) const {
  const double variance_mm2 = request_.amplitude.in_mm() * request_.amplitude.in_mm();
  const VectorXd trend_mm2 =
      kTrendSigma_mm * kTrendSigma_mm * trends(places).colwise().squaredNorm().transpose();
  return trend_mm2.array() + variance_mm2;
}

MatrixXd HeightBelief::trends(const SearchPlaces& places) const {
  MatrixXd out(request_.n_trend, static_cast<Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) {
    out.col(static_cast<Index>(i)) =
        trend_at((places[i].in_mm() - center_mm_) / scale_mm_, request_.n_trend);
  }
  return out;
}

/// Uncertainty that is left when some candidates are probed.
struct ProbeSearch::Given {
  MatrixXd shared;     ///< covariances of places and candidates with candidates
  VectorXd variances;  ///< of places

  auto of_places(Index candidate) const { return shared.col(candidate).head(variances.size()); }
  /// Of a reading there, but for the probe's own.
  double variance_at(Index candidate) const {
    return shared(variances.size() + candidate, candidate);
  }
};

ProbeSearch::ProbeSearch(const ProbePlanRequest& request,
                         const HeightBelief& belief,
                         const SearchPlaces& places)
    : request_(request) {
  const double tolerance_mm = request.tolerance.in_mm() * (1 - kSameSigma);
  most_mm2_ = tolerance_mm * tolerance_mm;
  noise_mm2_ = request.probe_sigma.in_mm() * request.probe_sigma.in_mm();
  SearchPlaces all = places;
  all.insert(all.end(), request.candidates.begin(), request.candidates.end());
  believed_ = belief(all, request.candidates);
  variances_ = belief.variances_mm2(places);
  if (request.present.empty()) return;
  SearchPlaces present;
  for (const ProbePoint& probe : request.present) present.push_back(probe.place);
  MatrixXd own = belief(present, present);
  for (Index i = 0; i < own.rows(); ++i) {
    const double sigma_mm = request.present[static_cast<std::size_t>(i)].measured.sigma.in_mm();
    own(i, i) += sigma_mm * sigma_mm;
  }
  const MatrixXd root = Cholesky(own).whiten(belief(present, all));
  believed_ -= root.transpose() * root.rightCols(believed_.cols());
  variances_ -= root.leftCols(variances_.size()).colwise().squaredNorm().transpose();
}

double ProbeSearch::excess(const VectorXd& variances) const {
  return (variances.array() - most_mm2_).max(0).sum();
}

MatrixXd ProbeSearch::made_independent(const Indices& chosen, Index n_with) const {
  const auto n = static_cast<Index>(chosen.size());
  MatrixXd own(n, n), with(n, n_with);
  for (Index i = 0; i < n; ++i) {
    const auto candidate = static_cast<Index>(chosen[static_cast<std::size_t>(i)]);
    with.row(i) = believed_.col(candidate).head(n_with).transpose();
    for (Index j = 0; j < n; ++j) {
      own(j, i) = believed_(
          variances_.size() + static_cast<Index>(chosen[static_cast<std::size_t>(j)]), candidate);
    }
    own(i, i) += noise_mm2_;
  }
  return Cholesky(own).whiten(with);
}

VectorXd ProbeSearch::variances_given(const Indices& chosen) const {
  if (chosen.empty()) return variances_;
  const MatrixXd root = made_independent(chosen, variances_.size());
  return variances_ - root.colwise().squaredNorm().transpose();
}

ProbeSearch::Given ProbeSearch::given(const Indices& chosen) const {
  Given out{believed_, variances_};
  if (chosen.empty()) return out;
  const MatrixXd root = made_independent(chosen, believed_.rows());
  out.shared.noalias() -= root.transpose() * root.rightCols(believed_.cols());
  out.variances -= root.leftCols(variances_.size()).colwise().squaredNorm().transpose();
  return out;
}

std::optional<ProbeSearch::Indices> ProbeSearch::greedy() const {
  Given known = given({});
  std::vector<bool> is_taken(request_.candidates.size(), false);
  Indices out;
  while (excess(known.variances) > 0) {
    std::optional<Index> best;
    double least = excess(known.variances);
    for (Index c = 0; c < known.shared.cols(); ++c) {
      if (is_taken[static_cast<std::size_t>(c)]) continue;
      const double variance = known.variance_at(c) + noise_mm2_;
      const double left = excess(known.variances - known.of_places(c).cwiseAbs2() / variance);
      if (left >= least) continue;
      least = left;
      best = c;
    }
    if (!best || out.size() + request_.present.size() >= kMostPlanned) return std::nullopt;
    is_taken[static_cast<std::size_t>(*best)] = true;
    out.push_back(static_cast<std::size_t>(*best));
    const double variance = known.variance_at(*best) + noise_mm2_;
    const VectorXd column = known.shared.col(*best);
    known.variances -= column.head(known.variances.size()).cwiseAbs2() / variance;
    const VectorXd row = column.tail(known.shared.cols()) / variance;
    known.shared.noalias() -= column * row.transpose();
  }
  return out;
}

bool ProbeSearch::is_enough(const Indices& chosen) const {
  return !(excess(variances_given(chosen)) > 0);
}

/// A probe left out raises a place's variance by (V B)_i^2 / B_ii, B the inverse of the probes'
/// covariance and V that of the place with them.
std::size_t ProbeSearch::least_needed(const Indices& chosen) const {
  const auto n = static_cast<Index>(chosen.size());
  MatrixXd own(n, n), with_places(variances_.size(), n);
  for (Index i = 0; i < n; ++i) {
    const auto candidate = static_cast<Index>(chosen[static_cast<std::size_t>(i)]);
    with_places.col(i) = believed_.col(candidate).head(variances_.size());
    for (Index j = 0; j < n; ++j) {
      own(j, i) = believed_(
          variances_.size() + static_cast<Index>(chosen[static_cast<std::size_t>(j)]), candidate);
    }
    own(i, i) += noise_mm2_;
  }
  const MatrixXd inverse = Cholesky(own).inverse();
  const MatrixXd weights = with_places * inverse;
  const VectorXd variances = variances_ - weights.cwiseProduct(with_places).rowwise().sum();
  std::size_t out = 0;
  double least = std::numeric_limits<double>::infinity(), least_sum = least;
  for (Index i = 0; i < n; ++i) {
    const VectorXd without = variances + weights.col(i).cwiseAbs2() / inverse(i, i);
    const double left = excess(without), sum = without.sum();
    if (left > least || (left == least && sum >= least_sum)) continue;
    least = left;
    least_sum = sum;
    out = static_cast<std::size_t>(i);
  }
  return out;
}

void ProbeSearch::prune(Indices& chosen) const {
  while (!chosen.empty()) {
    Indices fewer = chosen;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(least_needed(chosen)));
    if (!is_enough(fewer)) return;
    chosen = std::move(fewer);
  }
}

/// Moves probes until they are enough; false if that does not come about.
bool ProbeSearch::repair(Indices& chosen, int& n_moves) const {
  double now = excess(variances_given(chosen));
  bool has_moved = true;
  while (has_moved) {
    has_moved = false;
    for (std::size_t& probe : chosen) {
      if (!(now > 0)) return true;
      if (n_moves++ >= kMostMoves) return false;
      Indices others;
      for (const std::size_t other : chosen) {
        if (other != probe) others.push_back(other);
      }
      const Given known = given(others);
      std::size_t best = probe;
      double least = now * (1 - kLeastGain);
      for (Index c = 0; c < known.shared.cols(); ++c) {
        const auto candidate = static_cast<std::size_t>(c);
        if (std::ranges::find(others, candidate) != others.end()) continue;
        const double variance = known.variance_at(c) + noise_mm2_;
        const double left = excess(known.variances - known.of_places(c).cwiseAbs2() / variance);
        if (left >= least) continue;
        least = left;
        best = candidate;
      }
      if (best == probe) continue;
      probe = best;
      now = least;
      has_moved = true;
    }
  }
  return !(now > 0) && is_enough(chosen);
}

void ProbeSearch::thin_out(Indices& chosen) const {
  int n_moves = 0;
  while (chosen.size() > 1) {
    Indices fewer = chosen;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(least_needed(chosen)));
    if (!repair(fewer, n_moves)) return;
    chosen = std::move(fewer);
  }
}

std::size_t ProbeSearch::least_known(const Indices& chosen) const {
  const Given known = given(chosen);
  Index out = 0;
  for (Index c = 1; c < known.shared.cols(); ++c) {
    if (known.variance_at(c) > known.variance_at(out)) out = c;
  }
  return static_cast<std::size_t>(out);
}

}  // namespace panelcal::internal
