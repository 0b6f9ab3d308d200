// SPDX-License-Identifier: Apache-2.0
#include "calib/advice/visiting_order.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "calib/advice/visit_runs.h"
#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

namespace panelcal {
namespace {

using NominalPlace = Position<frame::Nominal>;
using Order = std::vector<std::size_t>;

std::vector<NominalPlace> random_places(int n, std::uint64_t seed) {
  Random random(seed);
  std::vector<NominalPlace> out;
  for (int i = 0; i < n; ++i) {
    out.push_back(position_mm<frame::Nominal>(random.uniform(0, 300), random.uniform(0, 300)));
  }
  return out;
}

Order counted(std::size_t n) {
  Order order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

bool keeps_phases(const Order& order, const std::vector<int>& phases) {
  return std::ranges::is_sorted(order, {}, [&](std::size_t i) { return phases[i]; });
}

TEST(VisitingOrder, IsTheShortestOfAllForFew) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto places = random_places(7, seed);
    const std::vector<int> phases = {0, 0, 0, 1, 1, 1, 2};
    double shortest_mm = std::numeric_limits<double>::infinity();
    Order order = counted(7);
    do {
      if (!keeps_phases(order, phases)) continue;
      shortest_mm = std::min(shortest_mm, way_length(places, order).in_mm());
    } while (std::ranges::next_permutation(order).found);
    const Order found = short_order(places, phases);
    EXPECT_TRUE(keeps_phases(found, phases));
    EXPECT_TRUE(std::ranges::is_permutation(found, counted(7)));
    EXPECT_NEAR(way_length(places, found).in_mm(), shortest_mm, 1e-9) << "seed " << seed;
  }
}

TEST(VisitingOrder, OfManyIsWithinAFewPercentOfTheBestKnown) {
  // A snake over a lattice is the shortest way: no step can be shorter than the pitch.
  std::vector<NominalPlace> places;
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 12; ++x) places.push_back(position_mm<frame::Nominal>(10.0 * x, 10.0 * y));
  }
  Random random(4);
  for (std::size_t i = places.size(); i > 1; --i) {
    std::swap(places[i - 1],
              places[static_cast<std::size_t>(random.uniform() * static_cast<double>(i))]);
  }
  const Order found = short_order(places, std::vector<int>(places.size(), 0));
  EXPECT_TRUE(std::ranges::is_permutation(found, counted(places.size())));
  EXPECT_GE(way_length(places, found).in_mm(), 1430 - 1e-9);
  EXPECT_LE(way_length(places, found).in_mm(), 1.01 * 1430);
}

TEST(VisitingOrder, IsNeverLongerThanTheGivenOneAndKeepsPhases) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto places = random_places(60, seed);
    std::vector<int> phases(60, 2);
    std::fill_n(phases.begin(), 4, 0);
    std::fill_n(phases.begin() + 4, 20, 1);
    const Order found = short_order(places, phases);
    EXPECT_TRUE(keeps_phases(found, phases));
    EXPECT_TRUE(std::ranges::is_permutation(found, counted(60)));
    EXPECT_LE(way_length(places, found), way_length(places, counted(60)));
    // No exchange of two neighbours and no turned pair helps any more.
    for (std::size_t i = 0; i + 1 < found.size(); ++i) {
      Order other = found;
      std::swap(other[i], other[i + 1]);
      if (!keeps_phases(other, phases)) continue;
      EXPECT_GE(way_length(places, other).in_mm(), way_length(places, found).in_mm() - 1e-5);
    }
  }
}

TEST(VisitingOrder, LivesWithPlacesOnEachOtherAndInALine) {
  std::vector<NominalPlace> places(30, position_mm<frame::Nominal>(5, 5));
  EXPECT_EQ(way_length(places, short_order(places, std::vector<int>(30, 0))), mm(0));
  places.clear();
  for (int i = 0; i < 40; ++i) places.push_back(position_mm<frame::Nominal>((i * 17) % 40, 0));
  EXPECT_NEAR(way_length(places, short_order(places, std::vector<int>(40, 0))).in_mm(), 39, 1e-9);
  EXPECT_TRUE(short_order({}, {}).empty());
  EXPECT_EQ(short_order(std::vector{places[0]}, std::vector{0}), Order{0});
}

TEST(VisitRuns, GiveAllCopiesTheSameInnerOrder) {
  // Three targets of a board, programmed back and forth, in three copies along x.
  std::vector<NominalPlace> places;
  std::vector<VisitRun> runs;
  for (int copy = 0; copy < 3; ++copy) {
    VisitRun run;
    for (const double x_mm : {10.0, 0.0, 20.0}) {
      run.places.push_back(places.size());
      places.push_back(position_mm<frame::Nominal>(100.0 * copy + x_mm, 0));
    }
    runs.push_back(run);
  }
  const Order order = order_within_runs(places, runs);
  EXPECT_EQ(order, (Order{1, 0, 2, 4, 3, 5, 7, 6, 8}));
  EXPECT_NEAR(way_length(places, order).in_mm(), 220, 1e-9);
}

TEST(VisitRuns, FindTheBestInnerOrderOfAll) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto places = random_places(12, seed);
    const std::vector<VisitRun> runs = {{0, {0, 1, 2, 3}}, {1, {4, 5, 6, 7}}, {1, {8, 9, 10, 11}}};
    const Length found = way_length(places, order_within_runs(places, runs));
    double shortest_mm = std::numeric_limits<double>::infinity();
    Order a = counted(4);
    do {
      Order b = counted(4);
      do {
        Order order = a;
        for (const std::size_t run : {1u, 2u}) {
          for (const std::size_t k : b) order.push_back(4 * run + k);
        }
        shortest_mm = std::min(shortest_mm, way_length(places, order).in_mm());
      } while (std::ranges::next_permutation(b).found);
    } while (std::ranges::next_permutation(a).found);
    // One kind after the other may end in a local optimum, but not far away.
    EXPECT_LE(found.in_mm(), 1.1 * shortest_mm) << "seed " << seed;
    EXPECT_GE(found.in_mm(), shortest_mm - 1e-9);
  }
}

}  // namespace
}  // namespace panelcal
