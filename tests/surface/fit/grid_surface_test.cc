// SPDX-License-Identifier: Apache-2.0
// Bilinear and monotone bicubic surfaces through the probes of a grid.
#include <algorithm>
#include <cmath>

#include "surface/fit/choice.h"
#include "surface/fit/fit.h"
#include "surface/map/height_map.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"
#include "tests/surface/fit/simulated_warp.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FailsWith;
using test::kWarpSide_mm;
using test::probed_lattice;
using test::SimulatedWarp;
using Points = std::vector<ProbePoint>;

constexpr SurfaceModel kGridModels[] = {SurfaceModel::Bilinear, SurfaceModel::MonotoneBicubic};

Points warped(std::uint64_t seed, int n_columns, int n_rows) {
  Random random(seed);
  const SimulatedWarp warp(random, 1);
  return probed_lattice(random, warp, n_columns, n_rows);
}

SurfaceFit fitted(const Points& points, SurfaceModel model) {
  const auto found = fit_surface(points, model);
  EXPECT_TRUE(found) << found.error().text();
  return *found;
}

Position<frame::Nominal> somewhere(Random& random) {
  return position_mm<frame::Nominal>(random.uniform(-0.5, 0.5) * kWarpSide_mm,
                                     random.uniform(-0.5, 0.5) * kWarpSide_mm);
}

/// Columns and rows that are not evenly spaced.
template <class Surface>
Points uneven(const Surface& surface) {
  Points out;
  for (const double y_mm : {-150.0, -130.0, -60.0, 0.0, 50.0, 150.0}) {
    for (const double x_mm : {-150.0, -100.0, -90.0, 10.0, 80.0, 120.0, 150.0}) {
      out.push_back({position_mm<frame::Nominal>(x_mm, y_mm),
                     {mm(surface(Vector2d(x_mm, y_mm))), um(1)},
                     "",
                     {"probes.jsonl", static_cast<int>(out.size()) + 1, 0}});
    }
  }
  return out;
}

TEST(GridSurface, PassesThroughEveryProbe) {
  const Points points = warped(101, 7, 6);
  for (const SurfaceModel model : kGridModels) {
    const SurfaceFit fit = fitted(points, model);
    for (const ProbePoint& point : points) {
      const HeightEstimate found = fit.at(point.place);
      EXPECT_NEAR((found.height - point.measured.height).in_mm(), 0, 1e-12);
      EXPECT_NEAR(found.sigma / point.measured.sigma, 1, 1e-6);
    }
    EXPECT_EQ(fit.noise_factor(), 1);
    EXPECT_EQ(fit.n_trend(), 0);
  }
}

TEST(GridSurface, IsExactForATiltedPlaneOnAnUnevenGrid) {
  const auto tilted = [](const Vector2d& p_mm) { return 1.6 + 1e-3 * p_mm.x() - 2e-3 * p_mm.y(); };
  Random random(102);
  for (const SurfaceModel model : kGridModels) {
    const SurfaceFit fit = fitted(uneven(tilted), model);
    for (int i = 0; i < 200; ++i) {
      const auto place = somewhere(random);
      EXPECT_NEAR(fit.at(place).height.in_mm(), tilted(place.in_mm()), 1e-12);
    }
    for (const LeftOutProbe& probe : fit.left_out()) {
      ASSERT_TRUE(probe.deviation);
      EXPECT_NEAR(probe.deviation->in_mm(), 0, 1e-12);
    }
  }
}

TEST(GridSurface, KnowsTheErrorOfAParabolaBetweenUnevenNodes) {
  const auto bowed = [](const Vector2d& p_mm) { return 1e-5 * p_mm.x() * p_mm.x(); };
  const SurfaceFit fit = fitted(uneven(bowed), SurfaceModel::Bilinear);
  // In the middle of the cell from -90 to 10 mm a chord is off by 1e-5 * 50^2 mm.
  const HeightEstimate middle = fit.at(position_mm<frame::Nominal>(-40, 0));
  EXPECT_NEAR((middle.height.in_mm() - bowed({-40, 0})), 0.025, 1e-9);
  EXPECT_NEAR(middle.sigma.in_mm(), 0.025, 0.0005);
}

TEST(GridSurface, NeverLeavesTheRangeOfItsProbes) {
  for (std::uint64_t seed = 103; seed < 108; ++seed) {
    Points points = warped(seed, 6, 8);
    // A step between two columns is what polynomials swing at.
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (i % 6 > 2) points[i].measured.height = points[i].measured.height + mm(0.5);
    }
    const auto [lowest, highest] = std::ranges::minmax(
        points, {}, [](const ProbePoint& point) { return point.measured.height; });
    Random random(seed);
    for (const SurfaceModel model : kGridModels) {
      const SurfaceFit fit = fitted(points, model);
      for (int i = 0; i < 1000; ++i) {
        const Length height = fit.at(somewhere(random)).height;
        EXPECT_GE(height, lowest.measured.height - mm(1e-12));
        EXPECT_LE(height, highest.measured.height + mm(1e-12));
      }
      // As a map, sampled on a lattice of its own, and outside of the probes as well.
      const auto map = HeightMap::of_probes(points, {.model = model});
      ASSERT_TRUE(map) << map.error().text();
      for (int i = 0; i < 1000; ++i) {
        const auto found =
            map->height_at(position_mm<frame::Nominal>(1.02 * somewhere(random).in_mm()));
        ASSERT_TRUE(found) << found.error().text();
        EXPECT_GE(found->height + 3 * found->sigma, lowest.measured.height);
        EXPECT_LE(found->height - 3 * found->sigma, highest.measured.height);
      }
    }
  }
}

/// Warps of 10 x 12 probes and of fewer and more; the trials are in
/// height_map_slow_test.cc.
TEST(GridSurface, SaysHonestlyHowSureItIs) {
  // Errors of one panel hang together, so that a panel's share is off by some %; 20 of them by one.
  constexpr int kPanels = 20;
  constexpr int kPlaces = 200;
  struct Case {
    int n_columns, n_rows;
    double least, most;
  };
  // A cubic misses much less of half the distance than of the whole, which is what left-out probes
  // tell: few probes of a smooth warp are known better than they say.
  for (const auto& [n_columns, n_rows, least, most] :
       {Case{5, 5, 0.92, 0.99}, Case{10, 12, 0.93, 0.97}, Case{20, 20, 0.93, 0.97}}) {
    for (const SurfaceModel model : kGridModels) {
      int n_within_95 = 0;
      for (int k = 0; k < kPanels; ++k) {
        Random random = Random(109).fork(static_cast<std::uint64_t>(k));
        const SimulatedWarp warp(random, k);
        const SurfaceFit fit = fitted(probed_lattice(random, warp, n_columns, n_rows), model);
        for (int i = 0; i < kPlaces; ++i) {
          const auto place = somewhere(random);
          const HeightEstimate found = fit.at(place);
          const double error_mm = found.height.in_mm() - warp(place.in_mm());
          n_within_95 += std::abs(error_mm) <= 1.96 * found.sigma.in_mm() ? 1 : 0;
        }
      }
      const double share = n_within_95 / static_cast<double>(kPanels * kPlaces);
      EXPECT_GE(share, least) << name_of(model) << " " << n_columns << " x " << n_rows;
      EXPECT_LE(share, most) << name_of(model) << " " << n_columns << " x " << n_rows;
    }
  }
}

TEST(GridSurface, NamesTheNodeThatIsMissingOrWild) {
  Points points = warped(110, 6, 5);
  points[6 * 2 + 3].measured.height = points[6 * 2 + 3].measured.height + mm(0.3);
  for (const SurfaceModel model : kGridModels) {
    EXPECT_THAT(fit_without_outliers(points, model),
                FailsWith(Code::GridInvalid, "column 3 row 2"));
  }
  points.erase(points.begin() + 6 * 2 + 3);
  for (const SurfaceModel model : kGridModels) {
    EXPECT_THAT(fit_surface(points, model), FailsWith(Code::GridInvalid));
  }
  EXPECT_THAT(fit_surface(warped(111, 2, 9), SurfaceModel::Bilinear),
              FailsWith(Code::GridInvalid, "2 x 9"));
  Points twice = warped(112, 4, 4);
  twice.push_back(twice.front());
  EXPECT_THAT(fit_surface(twice, SurfaceModel::MonotoneBicubic),
              FailsWith(Code::GridInvalid, "two"));
}

TEST(GridSurface, IsHeldAgainstTheOthersAndTakenOnlyIfBetter) {
  // A warp is smooth: a process predicts it better than neighbours do.
  const auto chosen = choose_surface(warped(113, 8, 7));
  ASSERT_TRUE(chosen) << chosen.error().text();
  EXPECT_FALSE(is_of_grid(chosen->surface.fit.model())) << chosen->reason;
  EXPECT_THAT(chosen->reason, ::testing::HasSubstr(" by bilinear, "));
  EXPECT_THAT(chosen->reason, ::testing::HasSubstr(" by monotone bicubic; "));
  Points scattered = warped(114, 8, 7);
  scattered.erase(scattered.begin() + 20);
  const auto without = choose_surface(scattered);
  ASSERT_TRUE(without) << without.error().text();
  EXPECT_THAT(without->reason, ::testing::Not(::testing::HasSubstr("bilinear")));
}

TEST(SurfaceChoice, TakesAGridModelOfMoreProbesThanAreSolvedFor) {
  Points points = warped(115, 60, 52);
  ASSERT_GT(points.size(), kMostBentProbes);
  const auto chosen = choose_surface(points);
  ASSERT_TRUE(chosen) << chosen.error().text();
  EXPECT_TRUE(is_of_grid(chosen->surface.fit.model()));
  EXPECT_THAT(chosen->reason, ::testing::HasSubstr("3120 probes are too many for other models"));
  points.erase(points.begin() + 20);
  EXPECT_THAT(choose_surface(points), FailsWith(Code::GridInvalid, "3119 probes"));
}

TEST(SurfaceChoice, RefusesWhereEveryThirdProbeIsWild) {
  struct Case {
    int n_columns, n_rows;
    double least_mm, most_mm;
  };
  for (const auto& [n_columns, n_rows, least_mm, most_mm] :
       {Case{8, 7, 0.1, 2}, Case{10, 12, 0.05, 0.3}, Case{5, 5, 0.2, 1}}) {
    for (std::uint64_t seed = 120; seed < 130; ++seed) {
      Points points = warped(seed, n_columns, n_rows);
      Random random(seed);
      for (std::size_t i = 0; i < points.size(); i += 3) {
        const double sign = random.uniform() < 0.5 ? -1 : 1;
        points[i].measured.height =
            points[i].measured.height + sign * mm(random.uniform(least_mm, most_mm));
      }
      EXPECT_THAT(choose_surface(points), FailsWith(Code::SurfaceOutOfTolerance))
          << n_columns << " x " << n_rows << ", seed " << seed;
      // No less so with a model that was asked for.
      if (seed > 121) continue;
      for (const SurfaceModel model : {SurfaceModel::Plane,
                                       SurfaceModel::ThinPlate,
                                       SurfaceModel::GaussianProcess,
                                       SurfaceModel::Bilinear}) {
        EXPECT_THAT(fit_without_outliers(points, model), FailsWith(Code::SurfaceOutOfTolerance))
            << name_of(model) << " " << n_columns << " x " << n_rows << ", seed " << seed;
      }
    }
  }
}

}  // namespace
}  // namespace panelcal
