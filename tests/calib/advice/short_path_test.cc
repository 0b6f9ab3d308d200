// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/short_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

namespace panelcal::internal {
namespace {

using PathOrder = std::vector<std::size_t>;

PathOrder in_order(std::size_t n) {
  PathOrder order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

Eigen::MatrixXd distances(const std::vector<Eigen::Vector2d>& places) {
  const auto n = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd out(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < n; ++k) {
      out(i, k) =
          (places[static_cast<std::size_t>(i)] - places[static_cast<std::size_t>(k)]).norm();
    }
  }
  return out;
}

/// Random places, and a cost around them that has nothing to do with these.
PathCosts random_costs(Eigen::Index n, Random& random) {
  std::vector<Eigen::Vector2d> places;
  for (Eigen::Index i = 0; i < n; ++i) {
    places.emplace_back(random.uniform(0, 100), random.uniform(0, 100));
  }
  PathCosts costs{distances(places), Eigen::MatrixXd(n, n)};
  for (double& cost : costs.around.reshaped()) cost = random.uniform(0, 200);
  return costs;
}

double least_of_all(const PathCosts& costs) {
  double least = std::numeric_limits<double>::infinity();
  PathOrder order = in_order(costs.size());
  do {
    least = std::min(least, costs.of(order));
  } while (std::ranges::next_permutation(order).found);
  return least;
}

/// Evenly on a circle, in an order that jumps.
std::vector<Eigen::Vector2d> ring(std::size_t n, std::size_t jump) {
  std::vector<Eigen::Vector2d> places;
  for (std::size_t i = 0; i < n; ++i) {
    const double angle =
        2 * std::numbers::pi * static_cast<double>(i * jump % n) / static_cast<double>(n);
    places.emplace_back(100 * std::cos(angle), 100 * std::sin(angle));
  }
  return places;
}

TEST(ShortPath, OfFewPlacesIsTheCheapestOfAll) {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    for (const Eigen::Index n : {1, 2, 3, 7}) {
      const PathCosts costs = random_costs(n, random);
      const PathOrder found = short_path(costs, in_order(costs.size()));
      EXPECT_TRUE(std::ranges::is_permutation(found, in_order(costs.size())));
      EXPECT_NEAR(costs.of(found), least_of_all(costs), 1e-5) << n << " places, trial " << trial;
    }
  }
}

TEST(ShortPath, OfManyPlacesFollowsARing) {
  for (const std::size_t n : {13, 40, 121}) {
    const auto size = static_cast<Eigen::Index>(n);
    const PathCosts costs{distances(ring(n, 7)), Eigen::MatrixXd::Zero(size, size)};
    const double chord = 200 * std::sin(std::numbers::pi / static_cast<double>(n));
    const PathOrder found = short_path(costs, in_order(n));
    EXPECT_TRUE(std::ranges::is_permutation(found, in_order(n)));
    EXPECT_NEAR(costs.of(found), static_cast<double>(n - 1) * chord, 1e-6) << n << " places";
  }
}

TEST(ShortPath, OfManyPlacesObeysWhatLeadsToItAndFollowsIt) {
  // The choice of the path's ends costs more than any way between.
  constexpr std::size_t kPlaces = 20;
  PathCosts costs{distances(ring(kPlaces, 3)), Eigen::MatrixXd::Constant(kPlaces, kPlaces, 1e4)};
  costs.around(11, 4) = 0;
  const PathOrder found = short_path(costs, in_order(kPlaces));
  EXPECT_EQ(found.front(), 4U);
  EXPECT_EQ(found.back(), 11U);
}

TEST(ShortPath, IsNeverDearerThanTheGivenOrder) {
  Random random(2);
  for (int trial = 0; trial < 5; ++trial) {
    for (const Eigen::Index n : {13, 30}) {
      const PathCosts costs = random_costs(n, random);
      const PathOrder given = in_order(costs.size());
      const PathOrder found = short_path(costs, given);
      EXPECT_TRUE(std::ranges::is_permutation(found, given));
      EXPECT_LE(costs.of(found), costs.of(given));
    }
  }
}

TEST(ShortPath, KeepsTheGivenOrderWhereNoneIsCheaper) {
  const PathCosts line{distances({{0, 0}, {1, 0}, {2, 0}, {3, 0}}), Eigen::MatrixXd::Zero(4, 4)};
  EXPECT_EQ(short_path(line, {3, 2, 1, 0}), (PathOrder{3, 2, 1, 0}));
  EXPECT_EQ(short_path({Eigen::MatrixXd(0, 0), Eigen::MatrixXd(0, 0)}, {}), PathOrder());
}

}  // namespace
}  // namespace panelcal::internal
