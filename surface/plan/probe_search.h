// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "surface/plan/request.h"
#include <Eigen/Core>

// Not installed: part of surface/plan/probe_plan.h.
namespace panelcal::internal {

/// Covariances of heights that are believed before anything is probed, mm^2.
class HeightBelief {
 public:
  using Places = std::vector<Position<frame::Nominal>>;

  /// The request must outlive it.
  explicit HeightBelief(const ProbePlanRequest& request);

  Eigen::MatrixXd operator()(const Places& a, const Places& b) const;
  Eigen::VectorXd variances_mm2(const Places& places) const;

 private:
  Eigen::MatrixXd trends(const Places& places) const;

  const ProbePlanRequest& request_;
  Eigen::Vector2d center_mm_;
  double scale_mm_;
};

/// Looks for few of the request's candidates that make some places sure enough.
///
/// Excess is the sum of what the places' variances exceed the tolerance by. Greedy: always the
/// candidate that leaves the least excess. Pruned: those without which there is still none are
/// dropped. Thinned: one more is dropped, and the others are moved one by one to where they leave
/// the least excess, until there is none again; so on, until that fails or kMostMoves are made.
///
/// Source Krause, McMahan, Guestrin and Gupta 2008 (truncated sums); Fedorov 1972 (exchanges)
class ProbeSearch {
 public:
  using Indices = std::vector<std::size_t>;
  using Places = HeightBelief::Places;

  static constexpr int kMostMoves = 150;

  /// The request must outlive it.
  ProbeSearch(const ProbePlanRequest& request, const HeightBelief& belief, const Places& places);

  /// Empty if all candidates are not enough.
  std::optional<Indices> greedy() const;
  bool is_enough(const Indices& chosen) const;
  void prune(Indices& chosen) const;
  void thin_out(Indices& chosen) const;
  /// The candidate of whose height least is known when these are probed.
  std::size_t least_known(const Indices& chosen) const;

 private:
  struct Given;

  double excess(const Eigen::VectorXd& variances) const;
  Given given(const Indices& chosen) const;
  Eigen::VectorXd variances_given(const Indices& chosen) const;
  /// The chosen probes' covariances with the first n places and candidates, as if of
  /// independent readings of variance 1.
  Eigen::MatrixXd made_independent(const Indices& chosen, Eigen::Index n_with) const;
  std::size_t least_needed(const Indices& chosen) const;
  bool repair(Indices& chosen, int& n_moves) const;

  const ProbePlanRequest& request_;
  Eigen::MatrixXd believed_;   ///< of places and candidates with candidates, present probes known
  Eigen::VectorXd variances_;  ///< of places, the same
  double most_mm2_;
  double noise_mm2_;
};

}  // namespace panelcal::internal
