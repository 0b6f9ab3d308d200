// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

// Not installed: part of calib/spindle/variance_components.h.
namespace panelcal::internal {

/// One variance to estimate: of groups or within them, along one axis or both.
struct Component {
  bool is_between = true;
  int axis = -1;  ///< -1: both
};

/// The observations of one group, one below the other.
struct Block {
  Eigen::MatrixXd design;
  Eigen::VectorXd value;
  Eigen::MatrixXd known;          ///< covariance
  std::vector<std::size_t> from;  ///< indices of the observations
};

/// The likelihood at some variances, and which way it rises.
struct LikelihoodState {
  Eigen::VectorXd theta;  ///< the variances
  Eigen::VectorXd fixed;
  Eigen::MatrixXd cov;  ///< of fixed
  double log_likelihood = -std::numeric_limits<double>::infinity();
  double chi_square = 0;
  Eigen::VectorXd score;
  Eigen::MatrixXd information;         ///< expected, of the variances
  std::vector<Eigen::MatrixXd> slope;  ///< d cov / d variance
};

/// The restricted likelihood of grouped observations.
///
///   -2 log L = sum log |V_g| + log |X' V^-1 X| + r' V^-1 r,   V_g = known_g + sum theta_k Z_gk
///
/// but for a constant.
/// Source Patterson and Thompson 1971; Searle, Casella and McCulloch 1992, 6.6 (derivatives)
class RestrictedLikelihood {
 public:
  /// Precondition: blocks is not empty; all have as many columns
  RestrictedLikelihood(std::vector<Block> blocks, std::vector<Component> components);

  const std::vector<Block>& blocks() const { return blocks_; }
  const std::vector<Component>& components() const { return components_; }
  Eigen::Index n_fixed() const { return blocks_.front().design.cols(); }
  Eigen::Index n_values() const;
  /// Of a block's values.
  Eigen::MatrixXd covariance(std::size_t i_block, const Eigen::VectorXd& theta) const;

  /// Without the derivatives; empty if the fixed effects are not determined.
  std::optional<LikelihoodState> at(const Eigen::VectorXd& theta) const;
  /// Adds the derivatives.
  void differentiate(LikelihoodState& state) const;

 private:
  struct Normal;
  std::optional<Normal> normal_equations(const Eigen::VectorXd& theta) const;

  std::vector<Block> blocks_;
  std::vector<Component> components_;
  std::vector<std::vector<Eigen::MatrixXd>> patterns_;  ///< by block, by component
};

}  // namespace panelcal::internal
