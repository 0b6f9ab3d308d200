// SPDX-License-Identifier: Apache-2.0
#include "calib/spindle/variance_components.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "calib/base/statistics/linear_algebra.h"
#include "calib/spindle/restricted_likelihood.h"
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxVarianceIterations = 200;
constexpr int kMaxHalvings = 40;
/// Of the variances, relative to all the scatter there is.
constexpr double kConverged = 1e-11;

std::vector<Component> components_of(const VarianceModel& model) {
  std::vector<Component> components;
  for (const bool is_between : {true, false}) {
    if (!is_between && !model.has_within) continue;
    if (!model.per_axis) components.push_back({is_between, -1});
    for (int axis = 0; model.per_axis && axis < 2; ++axis) components.push_back({is_between, axis});
  }
  return components;
}

bool is_sound_observation(const GroupedObservation& one, Eigen::Index n_fixed) {
  if (one.group < 0 || one.design.cols() != n_fixed) return false;
  if (!one.value_mm.allFinite() || !one.cov_mm2.allFinite() || !one.design.allFinite()) {
    return false;
  }
  const Eigen::Matrix2d& c = one.cov_mm2;
  return c(0, 1) == c(1, 0) && c(0, 0) > 0 && c(1, 1) > 0 && c(0, 0) * c(1, 1) > c(0, 1) * c(1, 0);
}

/// Groups in the order of their numbers, in units of `scale_mm`; empty if the input is not sound.
std::optional<std::vector<Block>> blocks_of(std::span<const GroupedObservation> observations,
                                            double scale_mm) {
  if (observations.empty()) return std::nullopt;
  const Eigen::Index n_fixed = observations.front().design.cols();
  std::vector<Block> blocks;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!is_sound_observation(observations[i], n_fixed)) return std::nullopt;
    const auto group = static_cast<std::size_t>(observations[i].group);
    if (group >= observations.size()) return std::nullopt;
    if (group >= blocks.size()) blocks.resize(group + 1);
    blocks[group].from.push_back(i);
  }
  for (Block& block : blocks) {
    const auto n = static_cast<Eigen::Index>(2 * block.from.size());
    if (n == 0) return std::nullopt;
    block.design.resize(n, n_fixed);
    block.value.resize(n);
    block.known = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index k = 0; k < n; k += 2) {
      const GroupedObservation& one = observations[block.from[static_cast<std::size_t>(k / 2)]];
      block.design.middleRows<2>(k) = one.design;
      block.value.segment<2>(k) = one.value_mm / scale_mm;
      block.known.block<2, 2>(k, k) = one.cov_mm2 / (scale_mm * scale_mm);
    }
  }
  return blocks;
}

/// Variances that are not zero, or that the likelihood wants larger.
std::vector<Eigen::Index> free_of(const LikelihoodState& state, bool is_final) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = 0; k < state.theta.size(); ++k) {
    if (state.theta[k] > 0 || (!is_final && state.score[k] > 0)) free.push_back(k);
  }
  return free;
}

/// Step of Fisher's scoring; or, with `is_plain`, each variance by itself.
Eigen::VectorXd step_of(const LikelihoodState& state, bool is_plain) {
  const std::vector<Eigen::Index> free = free_of(state, false);
  Eigen::VectorXd step = Eigen::VectorXd::Zero(state.theta.size());
  if (free.empty()) return step;
  const Eigen::MatrixXd information = state.information(free, free);
  const Eigen::VectorXd score = state.score(free);
  const Eigen::VectorXd diagonal = information.diagonal().cwiseMax(1e-300);
  if (is_plain) {
    const Eigen::VectorXd wanted = score.cwiseQuotient(diagonal);
    step(free) = wanted;
  } else {
    Eigen::MatrixXd ridged = information;
    ridged.diagonal() += 1e-12 * diagonal;
    const Eigen::VectorXd wanted = solve_symmetric(ridged, score);
    step(free) = wanted;
  }
  return step;
}

std::optional<LikelihoodState> climb(const RestrictedLikelihood& likelihood,
                                     const LikelihoodState& from,
                                     bool is_plain) {
  Eigen::VectorXd step = step_of(from, is_plain);
  if (!step.allFinite()) return std::nullopt;
  for (int i = 0; i < kMaxHalvings; ++i, step /= 2) {
    auto next = likelihood.at((from.theta + step).cwiseMax(0));
    if (next && next->log_likelihood > from.log_likelihood) return next;
  }
  return std::nullopt;
}

std::optional<LikelihoodState> maximum(const RestrictedLikelihood& likelihood) {
  // Half of the scatter, which is 1, for each.
  auto state = likelihood.at(
      Eigen::VectorXd::Constant(static_cast<Eigen::Index>(likelihood.components().size()), 0.5));
  if (!state) return std::nullopt;
  for (int i = 0; i < kMaxVarianceIterations; ++i) {
    likelihood.differentiate(*state);
    auto next = climb(likelihood, *state, false);
    if (!next) next = climb(likelihood, *state, true);
    if (!next) break;
    const double change = (next->theta - state->theta).cwiseAbs().maxCoeff();
    state = std::move(next);
    if (change < kConverged) break;
  }
  likelihood.differentiate(*state);
  return state;
}

/// Covariance of the variances; of one that is zero, what it would have by itself.
Eigen::MatrixXd covariance_of_variances(const LikelihoodState& state, bool with_zeros) {
  const std::vector<Eigen::Index> free = free_of(state, true);
  const Eigen::Index n = state.theta.size();
  Eigen::MatrixXd cov = Eigen::MatrixXd::Zero(n, n);
  if (!free.empty()) {
    const Eigen::MatrixXd information = state.information(free, free);
    const auto size = static_cast<Eigen::Index>(free.size());
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(size, size);
    const Eigen::MatrixXd inverse = solve_symmetric(information, unit);
    cov(free, free) = inverse;
  }
  for (Eigen::Index k = 0; with_zeros && k < n; ++k) {
    if (state.theta[k] > 0) continue;
    cov(k, k) = state.information(k, k) > 0 ? 1 / state.information(k, k) : 0;
  }
  return cov;
}

Eigen::VectorXd degrees_of_freedom(const LikelihoodState& state) {
  const Eigen::MatrixXd cov = covariance_of_variances(state, false);
  Eigen::VectorXd all = Eigen::VectorXd::Constant(state.fixed.size(), kInfinity);
  for (Eigen::Index j = 0; j < all.size(); ++j) {
    Eigen::VectorXd slope(state.theta.size());
    for (Eigen::Index k = 0; k < slope.size(); ++k) {
      slope[k] = state.slope[static_cast<std::size_t>(k)](j, j);
    }
    const double variance = slope.dot(cov * slope);
    if (variance > 0) all[j] = 2 * state.cov(j, j) * state.cov(j, j) / variance;
  }
  return all;
}

/// The weighted mean of residuals of covariance v.
GroupDeviation group_mean(const Eigen::VectorXd& residual, const Eigen::MatrixXd& v) {
  const Eigen::Index n = residual.size();
  Eigen::MatrixXd ones(n, 2);
  for (Eigen::Index k = 0; k < n; k += 2) ones.middleRows<2>(k) = Eigen::Matrix2d::Identity();
  const Eigen::MatrixXd weights = Cholesky(v).solve(ones);
  const Eigen::Matrix2d information = ones.transpose() * weights;
  GroupDeviation group;
  group.cov_mm2 = information.inverse();
  group.mean_mm = group.cov_mm2 * (weights.transpose() * residual);
  return group;
}

MixedFit result_of(const RestrictedLikelihood& likelihood,
                   const LikelihoodState& state,
                   const VarianceModel& model,
                   double scale_mm) {
  const double scale_mm2 = scale_mm * scale_mm;
  MixedFit fit;
  fit.model = model;
  fit.fixed = scale_mm * state.fixed;
  fit.cov = scale_mm2 * state.cov;
  fit.degrees_of_freedom = degrees_of_freedom(state);
  const Eigen::MatrixXd cov = covariance_of_variances(state, true);
  for (std::size_t k = 0; k < likelihood.components().size(); ++k) {
    const Component& component = likelihood.components()[k];
    VarianceEstimate& estimate = component.is_between ? fit.between : fit.within;
    const auto i = static_cast<Eigen::Index>(k);
    for (int axis = 0; axis < 2; ++axis) {
      if (component.axis >= 0 && component.axis != axis) continue;
      estimate.value_mm2[axis] = scale_mm2 * state.theta[i];
      estimate.error_mm2[axis] = scale_mm2 * std::sqrt(std::max(0.0, cov(i, i)));
    }
  }
  fit.gain.resize(likelihood.n_fixed(), likelihood.n_values());
  for (std::size_t i = 0; i < likelihood.blocks().size(); ++i) {
    const Block& block = likelihood.blocks()[i];
    const Eigen::MatrixXd v = likelihood.covariance(i, state.theta);
    GroupDeviation group = group_mean(block.value - block.design * state.fixed, v);
    fit.groups.push_back({scale_mm * group.mean_mm, scale_mm2 * group.cov_mm2});
    const Eigen::MatrixXd gain = state.cov * Cholesky(v).solve(block.design).transpose();
    for (std::size_t k = 0; k < block.from.size(); ++k) {
      fit.gain.middleCols<2>(static_cast<Eigen::Index>(2 * block.from[k])) =
          gain.middleCols<2>(static_cast<Eigen::Index>(2 * k));
    }
  }
  fit.chi_square = state.chi_square;
  fit.n_free = static_cast<int>(likelihood.n_values() - likelihood.n_fixed());
  fit.log_likelihood = state.log_likelihood;
  return fit;
}

/// Unit of all scatter, so that variances are of the size of 1: plain least squares' root mean
/// square residual and the known noise together.
std::optional<double> scale_of(std::span<const GroupedObservation> observations) {
  const auto blocks = blocks_of(observations, 1);
  if (!blocks) return std::nullopt;
  const Eigen::Index p = blocks->front().design.cols();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(p, p);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(p);
  for (const Block& block : *blocks) {
    normal += block.design.transpose() * block.design;
    right += block.design.transpose() * block.value;
  }
  const Eigen::VectorXd fixed = solve_symmetric(normal, right);
  double sum_mm2 = 0;
  Eigen::Index n = 0;
  for (const Block& block : *blocks) {
    sum_mm2 += (block.value - block.design * fixed).squaredNorm() + block.known.trace();
    n += block.value.size();
  }
  const double scale_mm = std::sqrt(sum_mm2 / static_cast<double>(n));
  if (!std::isfinite(scale_mm) || !(scale_mm > 0) || n <= p) return std::nullopt;
  return scale_mm;
}

}  // namespace

std::optional<Eigen::MatrixXd> MixedFit::honest_cov(int n) const {
  Eigen::VectorXd factor(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const double nu = degrees_of_freedom[j];
    if (!(nu > 2)) return std::nullopt;
    factor[j] = std::isinf(nu) ? 1 : std::sqrt(nu / (nu - 2));
  }
  const Eigen::MatrixXd inflated =
      factor.asDiagonal() * cov.topLeftCorner(n, n) * factor.asDiagonal();
  return inflated;
}

std::optional<MixedFit> fit_mixed(std::span<const GroupedObservation> observations,
                                  const VarianceModel& model) {
  const auto scale_mm = scale_of(observations);
  if (!scale_mm) return std::nullopt;
  auto blocks = blocks_of(observations, *scale_mm);
  if (!blocks) return std::nullopt;
  const RestrictedLikelihood likelihood(*std::move(blocks), components_of(model));
  const auto state = maximum(likelihood);
  if (!state) return std::nullopt;
  return result_of(likelihood, *state, model, *scale_mm);
}

std::optional<MixedFit> fit_fixed(std::span<const GroupedObservation> observations,
                                  double between_mm2,
                                  double within_mm2) {
  const bool is_told = std::isfinite(between_mm2) && std::isfinite(within_mm2) &&
                       between_mm2 >= 0 && within_mm2 >= 0;
  if (!is_told || !scale_of(observations)) return std::nullopt;
  auto blocks = blocks_of(observations, 1);
  if (!blocks) return std::nullopt;
  const RestrictedLikelihood likelihood(*std::move(blocks), components_of({}));
  auto state = likelihood.at(Eigen::Vector2d(between_mm2, within_mm2));
  if (!state) return std::nullopt;
  likelihood.differentiate(*state);
  MixedFit fit = result_of(likelihood, *state, {}, 1);
  fit.degrees_of_freedom.setConstant(kInfinity);
  fit.between.error_mm2.setZero();
  fit.within.error_mm2.setZero();
  return fit;
}

GroupDeviation deviation_of_other(const MixedFit& fit, std::span<const GroupedObservation> group) {
  const auto n = static_cast<Eigen::Index>(2 * group.size());
  Eigen::VectorXd residual(n);
  Eigen::MatrixXd design(n, fit.fixed.size());
  Eigen::MatrixXd v = Eigen::MatrixXd::Zero(n, n);
  const Eigen::Matrix2d between = fit.between.value_mm2.asDiagonal();
  const Eigen::Matrix2d within = fit.within.value_mm2.asDiagonal();
  for (Eigen::Index k = 0; k < n; k += 2) {
    const GroupedObservation& one = group[static_cast<std::size_t>(k / 2)];
    design.middleRows<2>(k) = one.design;
    residual.segment<2>(k) = one.value_mm - one.design * fit.fixed;
    for (Eigen::Index l = 0; l < n; l += 2) v.block<2, 2>(k, l) = between;
    v.block<2, 2>(k, k) += within + one.cov_mm2;
  }
  v += design * fit.cov * design.transpose();
  return group_mean(residual, v);
}

}  // namespace panelcal::internal
