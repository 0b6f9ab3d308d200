// SPDX-License-Identifier: Apache-2.0
#include "calib/spindle/restricted_likelihood.h"

#include <cmath>
#include <utility>

#include "calib/base/statistics/linear_algebra.h"

namespace panelcal::internal {
namespace {

/// Eigenvalues of scaled normal equations below it leave a fixed effect open.
constexpr double kSingular = 1e-10;

/// d covariance / d component for a group of n observations.
Eigen::MatrixXd pattern_of(const Component& component, Eigen::Index n_observations) {
  const Eigen::Index n = 2 * n_observations;
  Eigen::MatrixXd pattern = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index row = 0; row < n; ++row) {
    if (component.axis >= 0 && row % 2 != component.axis) continue;
    if (!component.is_between) {
      pattern(row, row) = 1;
      continue;
    }
    for (Eigen::Index column = row % 2; column < n; column += 2) pattern(row, column) = 1;
  }
  return pattern;
}

/// Subtracts what the fixed effects explain, which is known only when all groups are added up.
void finish_likelihood(const std::vector<Eigen::MatrixXd>& a, LikelihoodState& state) {
  state.slope.clear();
  for (std::size_t k = 0; k < a.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const Eigen::MatrixXd ca = state.cov * a[k];
    state.score[row] += 0.5 * ca.trace();
    for (std::size_t l = 0; l <= k; ++l) {
      const auto column = static_cast<Eigen::Index>(l);
      const Eigen::MatrixXd cb = state.cov * a[l];
      state.information(row, column) += 0.5 * ca.cwiseProduct(cb.transpose()).sum();
      state.information(column, row) = state.information(row, column);
    }
    state.slope.emplace_back(ca * state.cov);
  }
}

}  // namespace

struct RestrictedLikelihood::Normal {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double log_determinant = 0;  ///< of the values' covariance
};

RestrictedLikelihood::RestrictedLikelihood(std::vector<Block> blocks,
                                           std::vector<Component> components)
    : blocks_(std::move(blocks)), components_(std::move(components)) {
  for (const Block& block : blocks_) {
    std::vector<Eigen::MatrixXd> patterns;
    for (const Component& component : components_) {
      patterns.push_back(pattern_of(component, block.value.size() / 2));
    }
    patterns_.push_back(std::move(patterns));
  }
}

Eigen::Index RestrictedLikelihood::n_values() const {
  Eigen::Index n = 0;
  for (const Block& block : blocks_) n += block.value.size();
  return n;
}

Eigen::MatrixXd RestrictedLikelihood::covariance(std::size_t i_block,
                                                 const Eigen::VectorXd& theta) const {
  Eigen::MatrixXd v = blocks_[i_block].known;
  for (std::size_t k = 0; k < components_.size(); ++k) {
    v += theta[static_cast<Eigen::Index>(k)] * patterns_[i_block][k];
  }
  return v;
}

std::optional<RestrictedLikelihood::Normal> RestrictedLikelihood::normal_equations(
    const Eigen::VectorXd& theta) const {
  Normal normal{Eigen::MatrixXd::Zero(n_fixed(), n_fixed()), Eigen::VectorXd::Zero(n_fixed())};
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Cholesky root(covariance(i, theta));
    if (!root.is_definite()) return std::nullopt;
    const Eigen::MatrixXd x = root.whiten(blocks_[i].design);
    const Eigen::VectorXd y = root.whiten(blocks_[i].value);
    normal.matrix += x.transpose() * x;
    normal.right += x.transpose() * y;
    normal.log_determinant += root.log_determinant();
  }
  return normal;
}

std::optional<LikelihoodState> RestrictedLikelihood::at(const Eigen::VectorXd& theta) const {
  const auto normal = normal_equations(theta);
  if (!normal) return std::nullopt;
  const Eigen::VectorXd root = normal->matrix.diagonal().cwiseSqrt();
  if (!(root.array() > 0).all() || !root.allFinite()) return std::nullopt;
  const Eigen::VectorXd by_root = root.cwiseInverse();
  const Eigen::MatrixXd scaled = by_root.asDiagonal() * normal->matrix * by_root.asDiagonal();
  const Eigensystem eigen = eigensystem(scaled);
  if (!(eigen.values.minCoeff() > kSingular)) return std::nullopt;

  LikelihoodState state;
  state.theta = theta;
  const Eigen::MatrixXd inverse = Cholesky(scaled).inverse();
  state.cov = by_root.asDiagonal() * inverse * by_root.asDiagonal();
  state.fixed = state.cov * normal->right;
  // Of the residuals themselves: what is left of a difference of large numbers is noise.
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Eigen::VectorXd r = blocks_[i].value - blocks_[i].design * state.fixed;
    state.chi_square += r.dot(Cholesky(covariance(i, theta)).solve(r));
  }
  state.log_likelihood = -0.5 * (normal->log_determinant + eigen.values.array().log().sum() +
                                 2 * root.array().log().sum() + state.chi_square);
  if (!std::isfinite(state.log_likelihood)) return std::nullopt;
  return state;
}

void RestrictedLikelihood::differentiate(LikelihoodState& state) const {
  const std::size_t n = components_.size();
  const auto size = static_cast<Eigen::Index>(n);
  state.score = Eigen::VectorXd::Zero(size);
  state.information = Eigen::MatrixXd::Zero(size, size);
  std::vector<Eigen::MatrixXd> a(n, Eigen::MatrixXd::Zero(n_fixed(), n_fixed()));
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Cholesky factor(covariance(i, state.theta));
    const Eigen::VectorXd r = blocks_[i].value - blocks_[i].design * state.fixed;
    const Eigen::MatrixXd wx = factor.solve(blocks_[i].design);
    const Eigen::VectorXd wr = factor.solve(r);
    std::vector<Eigen::MatrixXd> wz;
    for (std::size_t k = 0; k < n; ++k) {
      const Eigen::MatrixXd& z = patterns_[i][k];
      wz.emplace_back(factor.solve(z));
      a[k] += wx.transpose() * z * wx;
      state.score[static_cast<Eigen::Index>(k)] += 0.5 * (wr.dot(z * wr) - wz[k].trace());
    }
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t l = 0; l <= k; ++l) {
        const Eigen::MatrixXd b = wx.transpose() * patterns_[i][k] * wz[l] * wx;
        state.information(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l)) +=
            0.5 * wz[k].cwiseProduct(wz[l].transpose()).sum() - (state.cov * b).trace();
      }
    }
  }
  finish_likelihood(a, state);
}

}  // namespace panelcal::internal
