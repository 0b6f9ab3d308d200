// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/minimiser.h"

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

/// Rosenbrock's valley, (1 - x)^2 + 100 (y - x^2)^2: its minimum is at (1, 1).
struct Valley {
  using State = Eigen::Vector2d;
  struct Equations {
    Eigen::Matrix2d h;
    Eigen::Vector2d g;
    double cost = 0;
  };
  int n_looks = 0;

  Equations equations_at(const State& p) {
    ++n_looks;
    const Eigen::Vector2d r(1 - p.x(), 10 * (p.y() - p.x() * p.x()));
    Eigen::Matrix2d j;
    j << -1, 0, -20 * p.x(), 10;
    return {j.transpose() * j, j.transpose() * r, r.squaredNorm()};
  }
  std::optional<MinimiserStep<State>> step(const State& p,
                                           const Equations& e,
                                           double damping) const {
    const Eigen::Vector2d x = -damped_solution<2>(e.h, e.g, damping);
    if (x.isZero(0) && e.cost > 0) return std::nullopt;
    return MinimiserStep<State>{p + x, x.norm() / 1e-6, x.dot(e.h * x)};
  }
};

TEST(Minimiser, FollowsAValleyToItsEnd) {
  Valley valley;
  const auto minimum = minimised(valley, {-1.2, 1}, {.max_iterations = 60});
  EXPECT_TRUE(minimum.converged);
  EXPECT_FALSE(minimum.is_singular);
  EXPECT_EQ(minimum.n_evaluations, valley.n_looks);
  EXPECT_LT((minimum.state - Eigen::Vector2d::Ones()).norm(), 1e-9);
}

TEST(Minimiser, NeverTakesARiseOfTheCost) {
  Valley valley;
  double last = valley.equations_at({-1.2, 1}).cost;
  for (int n = 1; n < 20; ++n) {
    const auto minimum = minimised(valley, {-1.2, 1}, {.max_iterations = n});
    EXPECT_LE(minimum.equations.cost, last) << n;
    last = minimum.equations.cost;
  }
}

TEST(Minimiser, SaysWhenThereIsNoStep) {
  struct Flat : Valley {
    Equations equations_at(const State&) {
      return {Eigen::Matrix2d::Constant(NAN), Eigen::Vector2d::Ones(), 1};
    }
  } flat;
  const auto minimum = minimised(flat, {3, 4}, {});
  EXPECT_TRUE(minimum.is_singular);
  EXPECT_FALSE(minimum.converged);
  EXPECT_EQ(minimum.state, Eigen::Vector2d(3, 4));
}

TEST(Minimiser, ReadsTheLowerPartOfTheMatrixAlone) {
  SmallMatrix<3> h(2, 2);
  h << 4, 777, 2, 3;
  SmallVector<3> g(2);
  g << 8, 7;
  const SmallVector<3> x = damped_solution<3>(h, g, 0);
  EXPECT_NEAR(x[0], 1.25, 1e-9);
  EXPECT_NEAR(x[1], 1.5, 1e-9);
}

}  // namespace
}  // namespace panelcal::internal
