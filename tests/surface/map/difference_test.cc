// SPDX-License-Identifier: Apache-2.0
#include "surface/map/difference.h"

#include <cmath>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "tests/support/matchers.h"
#include "tests/surface/fit/simulated_warp.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FailsWith;
using test::probed_lattice;
using test::SimulatedWarp;

/// A warped panel, with what `change(place_mm)` adds to it; 300 x 300 mm about the origin.
template <class Change>
StoredMap probed(std::uint64_t seed,
                 int n_columns,
                 int n_rows,
                 const Change& change,
                 SurfaceModel model = SurfaceModel::GaussianProcess) {
  Random panel(81);
  const SimulatedWarp warp(panel, 3);
  Random random(seed);
  const auto surface = [&](const Vector2d& p_mm) { return warp(p_mm) + change(p_mm); };
  std::vector<ProbePoint> points = probed_lattice(random, surface, n_columns, n_rows);
  auto map = HeightMap::of_probes(points, {.model = model});
  EXPECT_TRUE(map) << map.error().text();
  return {std::move(points), *std::move(map), {}, "panelcal test"};
}

double nothing(const Vector2d& /*p_mm*/) {
  return 0;
}

TEST(MapDifference, FindsOffsetTiltAndBow) {
  const StoredMap before = probed(1, 9, 8, nothing);
  const StoredMap after = probed(2, 8, 9, [](const Vector2d& p_mm) {
    return 0.02 + 1e-4 * p_mm.x() + 0.03 * p_mm.y() * p_mm.y() / (150 * 150);
  });
  const auto found = difference_of(before, after);
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_TRUE(found->bow_y_um);
  // Two maps of 72 probes of 3 um leave 5.13 um/m of a tilt by least squares.
  static constexpr double kMostSigma = 5.2;
  const auto is = [](const Measured& measured, double right) {
    EXPECT_NEAR(measured.value, right, 4 * measured.sigma);
    EXPECT_LT(measured.sigma, kMostSigma);
  };
  is(found->tilt_x, 100);
  is(found->tilt_y, 0);
  is(*found->bow_y_um, 30);
  is(*found->bow_x_um, 0);
  is(*found->twist_um, 0);
  EXPECT_LT(found->offset.chance, 1e-6);
  EXPECT_LT(found->tilt.chance, 1e-6);
  EXPECT_LT(found->bow->chance, 1e-6);
  EXPECT_GT(found->rest->chance, 1e-3);
  // At the corners x = 150: 20 + 15 + 30 um.
  EXPECT_NEAR(found->greatest.in_um(), 65, 12);
  EXPECT_EQ(found->n_outside, 0U);
}

TEST(MapDifference, CallsNoiseNoise) {
  // Chances of no change are even; of 40, two or three are below 0.06 and some above 0.5.
  const StoredMap before = probed(1, 9, 8, nothing);
  int n_low = 0, n_high = 0;
  for (std::uint64_t seed = 100; seed < 140; ++seed) {
    const auto found = difference_of(before, probed(seed, 8, 7, nothing));
    ASSERT_TRUE(found) << found.error().text();
    n_low += found->all.chance < 0.06 ? 1 : 0;
    n_high += found->all.chance > 0.5 ? 1 : 0;
  }
  EXPECT_LE(n_low, 9);
  EXPECT_GE(n_high, 6);
}

TEST(MapDifference, JudgesAGridModelByItsProbes) {
  const StoredMap before = probed(1, 9, 8, nothing, SurfaceModel::Bilinear);
  const auto same = difference_of(before, probed(2, 9, 8, nothing, SurfaceModel::Bilinear));
  ASSERT_TRUE(same) << same.error().text();
  EXPECT_EQ(same->model, SurfaceModel::GaussianProcess);
  EXPECT_GT(same->all.chance, 0.01);
  const auto raised = [](const Vector2d& /*p_mm*/) { return 0.02; };
  const auto moved = difference_of(before, probed(3, 9, 8, raised, SurfaceModel::Bilinear));
  ASSERT_TRUE(moved) << moved.error().text();
  EXPECT_LT(moved->offset.chance, 1e-6);
  EXPECT_NEAR(moved->offset_um.value, 20, 4 * moved->offset_um.sigma);
  EXPECT_GT(moved->rest->chance, 1e-3);
}

TEST(MapDifference, FindsADentThatIsNoBow) {
  const StoredMap before = probed(1, 13, 13, nothing);
  const StoredMap after = probed(3, 13, 13, [](const Vector2d& p_mm) {
    return -0.06 * std::exp(-(p_mm - Vector2d(60, -40)).squaredNorm() / (2 * 30 * 30));
  });
  const auto found = difference_of(before, after);
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_LT(found->rest->chance, 1e-4);
  EXPECT_LT(found->greatest, um(-35));
  EXPECT_LT((found->greatest_at.in_mm() - Vector2d(60, -40)).norm(), 30);
}

TEST(MapDifference, RefusesMapsThatHaveNothingInCommon) {
  const StoredMap before = probed(1, 9, 8, nothing);
  std::vector<ProbePoint> moved = before.points;
  for (ProbePoint& point : moved) {
    point.place = position_mm<frame::Nominal>(Vector2d(point.place.in_mm() + Vector2d(400, 0)));
  }
  auto map =
      HeightMap::of_probes(moved, {.model = SurfaceModel::Plane, .outliers = {.most_noise = 1e3}});
  ASSERT_TRUE(map) << map.error().text();
  const StoredMap after{moved, *std::move(map), {}, ""};
  EXPECT_THAT(difference_of(before, after), FailsWith(Code::GridInvalid, "0 probes"));
}

}  // namespace
}  // namespace panelcal
