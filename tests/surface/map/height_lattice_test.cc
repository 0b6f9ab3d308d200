// SPDX-License-Identifier: Apache-2.0
#include "surface/map/height_lattice.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FailsWith;
using Heights = std::vector<double>;

constexpr auto kBilinear = LatticeInterpolation::Bilinear;
constexpr auto kBicubic = LatticeInterpolation::MonotoneBicubic;
/// Of heights of about 10 mm.
constexpr double kRounding_mm = 1e-13;

constexpr LatticeAxis kX{-20, 5, 9};
constexpr LatticeAxis kY{100, 4, 7};

template <class Surface>
Heights sampled(const Surface& surface, const LatticeAxis& x = kX, const LatticeAxis& y = kY) {
  Heights out;
  for (int j = 0; j < y.n_nodes; ++j) {
    for (int i = 0; i < x.n_nodes; ++i) out.push_back(surface(x.at_mm(i), y.at_mm(j)));
  }
  return out;
}

HeightLattice made(const LatticeAxis& x,
                   const LatticeAxis& y,
                   const Heights& heights_mm,
                   LatticeInterpolation interpolation) {
  auto lattice = HeightLattice::make(x, y, heights_mm, interpolation);
  EXPECT_TRUE(lattice) << lattice.error().text();
  return *std::move(lattice);
}

Vector2d random_place(Random& random) {
  return {random.uniform(kX.first_mm, kX.last_mm()), random.uniform(kY.first_mm, kY.last_mm())};
}

TEST(HeightLattice, PassesThroughItsNodes) {
  Random random(31);
  const Heights heights = sampled([&](double, double) { return random.normal(); });
  for (const auto interpolation : {kBilinear, kBicubic}) {
    const HeightLattice lattice = made(kX, kY, heights, interpolation);
    for (int j = 0; j < kY.n_nodes; ++j) {
      for (int i = 0; i < kX.n_nodes; ++i) {
        const double node_mm = heights[static_cast<std::size_t>(j * kX.n_nodes + i)];
        EXPECT_NEAR(lattice.height_mm({kX.at_mm(i), kY.at_mm(j)}), node_mm, kRounding_mm);
      }
    }
  }
}

TEST(HeightLattice, IsExactForAPlaneAndForATwist) {
  const auto twisted = [](double x, double y) { return 1 + 0.01 * x - 0.02 * y + 1e-3 * x * y; };
  Random random(32);
  const HeightLattice bilinear = made(kX, kY, sampled(twisted), kBilinear);
  const auto tilted = [](double x, double y) { return 1 + 0.01 * x - 0.02 * y; };
  const HeightLattice bicubic = made(kX, kY, sampled(tilted), kBicubic);
  for (int k = 0; k < 100; ++k) {
    const Vector2d p_mm = random_place(random);
    EXPECT_NEAR(bilinear.height_mm(p_mm), twisted(p_mm.x(), p_mm.y()), kRounding_mm);
    EXPECT_NEAR(bicubic.height_mm(p_mm), tilted(p_mm.x(), p_mm.y()), kRounding_mm);
  }
}

TEST(HeightLattice, NeverLeavesTheRangeOfACellsNodes) {
  Random random(33);
  for (int trial = 0; trial < 200; ++trial) {
    // Rough surfaces, steps and spikes.
    const Heights heights = sampled([&](double x, double) {
      return trial % 2 == 0 ? random.normal() : (x > 0 ? 1 : 0) + (random.uniform() < 0.1 ? 9 : 0);
    });
    for (const auto interpolation : {kBilinear, kBicubic}) {
      const HeightLattice lattice = made(kX, kY, heights, interpolation);
      for (int k = 0; k < 500; ++k) {
        const Vector2d p_mm = random_place(random);
        const std::size_t cell = lattice.cell_of(p_mm);
        const std::size_t node = cell / 8 * 9 + cell % 8;
        const auto [low, high] =
            std::minmax({heights[node], heights[node + 1], heights[node + 9], heights[node + 10]});
        ASSERT_GE(lattice.height_mm(p_mm), low - kRounding_mm);
        ASSERT_LE(lattice.height_mm(p_mm), high + kRounding_mm);
      }
    }
  }
}

TEST(HeightLattice, RisesWhereItsNodesRise) {
  Random random(34);
  double row = 0;
  const Heights heights = sampled([&](double x, double) {
    if (x == kX.first_mm) row = 0;
    return row += random.uniform() < 0.3 ? 0 : random.uniform();
  });
  const HeightLattice lattice = made(kX, kY, heights, kBicubic);
  for (int j = 0; j < kY.n_nodes; ++j) {
    double before_mm = -1;
    for (double x_mm = kX.first_mm; x_mm <= kX.last_mm(); x_mm += 0.05) {
      const double height_mm = lattice.height_mm({x_mm, kY.at_mm(j)});
      EXPECT_GE(height_mm, before_mm - kRounding_mm);
      before_mm = height_mm;
    }
  }
}

/// Worst error at random places of a surface that rises and bends, on a lattice of this step.
double worst_error_mm(double step_mm, LatticeInterpolation interpolation) {
  const auto surface = [](double x, double y) {
    return std::exp(0.02 * x) + std::exp(0.015 * y) + 1e-4 * x * y;
  };
  const LatticeAxis x{0, step_mm, static_cast<int>(80 / step_mm) + 1};
  const HeightLattice lattice = made(x, x, sampled(surface, x, x), interpolation);
  Random random(35);
  double worst_mm = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vector2d p_mm(random.uniform(0, 80), random.uniform(0, 80));
    worst_mm = std::max(worst_mm, std::abs(lattice.height_mm(p_mm) - surface(p_mm.x(), p_mm.y())));
  }
  return worst_mm;
}

TEST(HeightLattice, IsOfSecondAndOfThirdOrder) {
  EXPECT_NEAR(worst_error_mm(8, kBilinear) / worst_error_mm(4, kBilinear), 4, 0.6);
  EXPECT_NEAR(worst_error_mm(8, kBicubic) / worst_error_mm(4, kBicubic), 8, 2);
  EXPECT_LT(worst_error_mm(4, kBicubic), 0.1 * worst_error_mm(4, kBilinear));
}

TEST(HeightLattice, HasNoKinksBetweenCells) {
  const auto surface = [](double x, double y) { return std::exp(0.03 * x) * std::exp(0.01 * y); };
  const HeightLattice lattice = made(kX, kY, sampled(surface), kBicubic);
  // The bend gives 3e-6 of slope; slopes are 0.02 to 0.1.
  constexpr double kStep_mm = 1e-3;
  for (double y_mm = 101; y_mm < 120; y_mm += 2.5) {
    const double here = lattice.height_mm({0, y_mm});
    const double before = (here - lattice.height_mm({-kStep_mm, y_mm})) / kStep_mm;
    const double behind = (lattice.height_mm({kStep_mm, y_mm}) - here) / kStep_mm;
    EXPECT_NEAR(before, behind, 1e-5);
  }
}

TEST(HeightLattice, TakesTheEdgeOutsideAndSaysSo) {
  Random random(36);
  const Heights heights = sampled([&](double, double) { return random.normal(); });
  const HeightLattice lattice = made(kX, kY, heights, kBicubic);
  EXPECT_NEAR(lattice.height_mm({-1e9, 99}), heights.front(), kRounding_mm);
  EXPECT_NEAR(lattice.height_mm({1e9, 1e300}), heights.back(), kRounding_mm);
  EXPECT_TRUE(lattice.is_inside({kX.first_mm, kY.last_mm()}));
  EXPECT_TRUE(lattice.is_inside({kX.last_mm(), kY.first_mm}));
  EXPECT_FALSE(lattice.is_inside({kX.last_mm() + 1e-9, 101}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(lattice.is_inside({nan, 101}));
  EXPECT_FALSE(lattice.is_inside({0, nan}));
}

/// Within, at nodes and borders and next to them, outside, and no places at all.
Vector2d any_place(Random& random) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  constexpr double kOdd[] = {std::numeric_limits<double>::quiet_NaN(),
                             kInf,
                             -kInf,
                             std::numeric_limits<double>::max(),
                             -std::numeric_limits<double>::max(),
                             std::numeric_limits<double>::denorm_min(),
                             -0.0};
  const auto coordinate = [&](const LatticeAxis& axis) {
    const double kind = random.uniform();
    if (kind < 0.6) return random.uniform(axis.first_mm, axis.last_mm());
    if (kind < 0.7) return random.uniform(axis.first_mm - 9, axis.last_mm() + 9);
    if (kind < 0.8) return kOdd[static_cast<std::size_t>(random.uniform(0, std::size(kOdd)))];
    const double node_mm = axis.at_mm(static_cast<int>(random.uniform(0, axis.n_nodes)));
    return kind < 0.9 ? node_mm : std::nextafter(node_mm, random.uniform() < 0.5 ? -1e9 : 1e9);
  };
  const double x_mm = coordinate(kX);
  return {x_mm, coordinate(kY)};
}

/// One place is looked up as any processor can, many as this one can best.
TEST(HeightLattice, IsTheSameToTheBitForManyPlaces) {
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "one place after the other, as single ones";
#endif
  Random random(37);
  const Heights heights = sampled([&](double, double) { return random.normal(); });
  for (const auto interpolation : {kBilinear, kBicubic}) {
    const HeightLattice lattice = made(kX, kY, heights, interpolation);
    for (std::size_t n = 0; n < 400; ++n) {
      const bool has_odd = n % 2 == 0;
      std::vector<Vector2d> places_mm;
      for (std::size_t k = 0; k < n; ++k) {
        places_mm.push_back(has_odd ? any_place(random) : random_place(random));
      }
      std::vector<std::uint8_t> marks(lattice.n_cells(), 0);
      marks[static_cast<std::size_t>(random.uniform(0, static_cast<double>(marks.size())))] = 4;
      const bool is_outside = std::ranges::any_of(
          places_mm, [&](const Vector2d& p_mm) { return !lattice.is_inside(p_mm); });
      const bool is_marked = std::ranges::any_of(
          places_mm, [&](const Vector2d& p_mm) { return marks[lattice.cell_of(p_mm)] != 0; });
      Heights plain(n), marked(n);
      EXPECT_EQ(lattice.heights_mm(places_mm, plain, {}), is_outside);
      EXPECT_EQ(lattice.heights_mm(places_mm, marked, marks), is_outside || is_marked);
      for (std::size_t k = 0; k < n; ++k) {
        const auto one = std::bit_cast<std::uint64_t>(lattice.height_mm(places_mm[k]));
        ASSERT_EQ(std::bit_cast<std::uint64_t>(plain[k]), one) << places_mm[k].transpose();
        ASSERT_EQ(std::bit_cast<std::uint64_t>(marked[k]), one) << places_mm[k].transpose();
      }
    }
  }
}

TEST(HeightLattice, SeesEveryMarkAndEveryPlaceOutside) {
  Random random(38);
  const Heights heights = sampled([&](double, double) { return random.normal(); });
  // The first four, and those that are left over behind the last four.
  constexpr std::size_t kPlaces = 11;
  for (const auto interpolation : {kBilinear, kBicubic}) {
    const HeightLattice lattice = made(kX, kY, heights, interpolation);
    for (std::size_t odd = 0; odd < kPlaces; ++odd) {
      std::vector<Vector2d> places_mm(kPlaces, Vector2d(kX.at_mm(2) + 1, kY.at_mm(3) + 1));
      Heights out(kPlaces);
      std::vector<std::uint8_t> marks(lattice.n_cells(), 0);
      EXPECT_FALSE(lattice.heights_mm(places_mm, out, marks));
      places_mm[odd] = {kX.at_mm(5) + 1, kY.at_mm(1) + 1};
      marks[lattice.cell_of(places_mm[odd])] = 1;
      EXPECT_TRUE(lattice.heights_mm(places_mm, out, marks)) << odd;
      EXPECT_FALSE(lattice.heights_mm(places_mm, out, {})) << odd;
      places_mm[odd].x() = kX.last_mm() + 1;
      EXPECT_TRUE(lattice.heights_mm(places_mm, out, {})) << odd;
    }
  }
}

TEST(HeightLattice, TakesNoMoreThanItIsGiven) {
  const auto tilted = [](double x, double) { return 0.1 * x; };
  const HeightLattice lattice = made(kX, kY, sampled(tilted), kBicubic);
  const std::vector<Vector2d> places_mm(3, Vector2d(10, 110));
  Heights out(5, -1.0);
  EXPECT_TRUE(lattice.heights_mm(places_mm, std::span(out).first(2), {}));
  EXPECT_EQ(out[2], -1);
  EXPECT_TRUE(lattice.heights_mm(places_mm, out, {}));
  EXPECT_EQ(out[3], -1);
  EXPECT_NEAR(out[2], 1, kRounding_mm);
  const std::vector<std::uint8_t> marks(3, 0);
  EXPECT_TRUE(lattice.heights_mm(places_mm, std::span(out).first(3), marks));
}

TEST(HeightLattice, RefusesWhatIsNoLattice) {
  const auto flat = [](double, double) { return 1.6; };
  const Heights heights_mm = sampled(flat);
  const double inf = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const int n_nodes : {1, 0, -3}) {
    EXPECT_THAT(HeightLattice::make({0, 1, n_nodes}, kY, heights_mm, kBicubic),
                FailsWith(Code::GridInvalid, "along x"));
  }
  for (const double step_mm : {0.0, -1.0, nan, inf, 1e-320}) {
    EXPECT_THAT(HeightLattice::make(kX, {100, step_mm, 7}, heights_mm, kBilinear),
                FailsWith(Code::GridInvalid, "along y"));
  }
  for (const double first_mm : {nan, inf, -inf}) {
    EXPECT_THAT(HeightLattice::make({first_mm, 5, 9}, kY, heights_mm, kBilinear),
                FailsWith(Code::GridInvalid, "along x"));
  }
  EXPECT_THAT(HeightLattice::make(kX, kY, std::span(heights_mm).first(62), kBicubic),
              FailsWith(Code::GridInvalid, "62 heights"));
  EXPECT_THAT(HeightLattice::make({0, 1, 1 << 20}, {0, 1, 1 << 20}, heights_mm, kBicubic),
              FailsWith(Code::GridInvalid, "63 heights"));
  Heights broken_mm = heights_mm;
  broken_mm[11] = nan;
  EXPECT_THAT(HeightLattice::make(kX, kY, broken_mm, kBicubic), FailsWith(Code::GridInvalid));
}

}  // namespace
}  // namespace panelcal
