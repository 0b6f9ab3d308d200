// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Core>

// Not installed.
namespace panelcal::internal {

template <int kMost>
using SmallMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMost, kMost>;
template <int kMost>
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMost, 1>;

/// (H + damping diag(H))^-1 g; zero if H is not positive definite. Only its lower part is read.
template <int kMost>
SmallVector<kMost> damped_solution(SmallMatrix<kMost> h,
                                   const SmallVector<kMost>& g,
                                   double damping) {
  for (Eigen::Index i = 0; i < h.rows(); ++i) h(i, i) += damping * h(i, i) + 1e-12;
  const Eigen::LDLT<SmallMatrix<kMost>> factor(h);
  SmallVector<kMost> x = SmallVector<kMost>::Zero(h.rows());
  if (factor.info() == Eigen::Success && factor.isPositive()) x = factor.solve(g);
  if (!x.allFinite()) x.setZero();
  return x;
}

struct MinimiserOptions {
  int max_iterations = 20;
  double first_damping = 1e-4;
  double damping_after_failure = 1e-3;  ///< at least
  double cost_rounding = 1e-10;         ///< of the cost: a smaller rise is taken
};

/// A step from a state.
template <class State>
struct MinimiserStep {
  State next;
  double move = 0;  ///< below 1 it is the last: the next would be about its square
  double fall = 0;  ///< x^T H x: the scale of the cost's change
};

template <class State, class Equations>
struct Minimum {
  State state;
  Equations equations;  ///< at the last state but for a last small step
  int n_evaluations = 1;
  bool converged = false;
  bool is_singular = false;  ///< a step could not be found
};

/// Levenberg and Marquardt's method for small problems that sum up their own normal equations:
///
///   Problem::State, Problem::Equations   the latter with a `cost`
///   Equations equations_at(const State&)
///   std::optional<MinimiserStep<State>> step(const State&, const Equations&, double damping)
///
/// The step is the problem's own: it keeps lengths and blurs where its model means something.
///
/// Source Marquardt 1963
/// Cost   a third of Ceres' TinySolver for the rim of a disc of 40 px (2,900 pixels, paired runs of
///        40 pictures: 2.4 to 4.2 times as long): that wants a row of doubles for each residual,
///        where here flat pixels are a few sums and rows are added up as floats
template <class Problem>
Minimum<typename Problem::State, typename Problem::Equations> minimised(
    Problem& problem, typename Problem::State start, const MinimiserOptions& options) {
  constexpr double kMostDamping = 1e8;
  constexpr double kLeastDamping = 1e-9;
  constexpr double kFree = 0.1;  // with more damping a small step does not tell of the minimum
  auto equations = problem.equations_at(start);
  Minimum<typename Problem::State, typename Problem::Equations> minimum{std::move(start),
                                                                        std::move(equations)};
  double damping = options.first_damping;
  for (int i = 0; i < options.max_iterations && damping < kMostDamping; ++i) {
    auto step = problem.step(minimum.state, minimum.equations, damping);
    minimum.is_singular = !step;
    if (!step) break;
    if (step->move < 1 && damping < kFree) {
      minimum.state = std::move(step->next);
      minimum.converged = true;
      break;
    }
    auto next = problem.equations_at(step->next);
    ++minimum.n_evaluations;
    const double scale = std::abs(minimum.equations.cost) + step->fall;
    if (next.cost <= minimum.equations.cost + options.cost_rounding * scale) {
      minimum.state = std::move(step->next);
      minimum.equations = std::move(next);
      damping = std::max(kLeastDamping, damping * 0.1);
    } else {
      damping = std::max(options.damping_after_failure, damping * 10);
    }
  }
  return minimum;
}

}  // namespace panelcal::internal
