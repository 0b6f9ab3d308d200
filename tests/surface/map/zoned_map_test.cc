// SPDX-License-Identifier: Apache-2.0
#include "surface/map/zoned_map.h"

#include <algorithm>

#include "surface/files/height_grid.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"
#include "tests/surface/fit/simulated_warp.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::probed_lattice;
using Points = std::vector<ProbePoint>;

Position<frame::Nominal> at(double x_mm, double y_mm) {
  return position_mm<frame::Nominal>(x_mm, y_mm);
}

/// 13 x 13 probes, 25 mm apart, of two panels side by side: tilted to the left, and 1 mm higher and
/// level to the right.
double two_panels(const Eigen::Vector2d& p_mm) {
  return p_mm.x() < 5 ? 1.6 + 1e-3 * p_mm.y() : 2.6;
}

Points two_panels_probed() {
  Random random(150);
  return probed_lattice(random, two_panels, 13, 13);
}

const Zone kLeft = {rectangle(at(-151, -151), at(2, 151)), "left"};
const Zone kRight = {rectangle(at(12, -151), at(151, 151)), "right"};

TEST(ZonedMap, GivesEachZoneItsOwnSurface) {
  const auto map = ZonedMap::of_probes(two_panels_probed(), {kLeft, kRight}, {});
  ASSERT_TRUE(map) << map.error().text();
  EXPECT_TRUE(map->unused().empty());
  const auto left = map->height_at(at(-1, 100)), right = map->height_at(at(26, 100));
  ASSERT_TRUE(left) << left.error().text();
  ASSERT_TRUE(right) << right.error().text();
  EXPECT_NEAR(left->height.height.in_mm(), 1.7, 0.005);
  EXPECT_EQ(left->i_zone, 0U);
  EXPECT_NEAR(right->height.height.in_mm(), 2.6, 0.005);
  EXPECT_EQ(right->i_zone, 1U);
  EXPECT_EQ(map->map(1).surface().model(), SurfaceModel::Plane);
  EXPECT_THAT(map->height_at(at(7, 0)), FailsWith(Code::GridInvalid, "(7.000, 0.000)"));
}

TEST(ZonedMap, TakesTheZoneDeclaredFirstWhereTwoOverlap) {
  const Zone all = {rectangle(at(-151, -151), at(151, 151)),
                    "all",
                    {.model = SurfaceModel::Plane, .outliers = {.most_noise = 1e6}}};
  const auto map = ZonedMap::of_probes(two_panels_probed(), {kRight, all}, {});
  ASSERT_TRUE(map) << map.error().text();
  EXPECT_EQ(map->height_at(at(100, 0))->i_zone, 0U);
  EXPECT_EQ(map->height_at(at(-100, 0))->i_zone, 1U);
  // The probes of the first one are not the second one's too.
  EXPECT_NEAR(map->height_at(at(-100, 0))->height.height.in_mm(), 1.6, 0.005);
}

TEST(ZonedMap, DoesNotBelieveProbesInVoidsAndSaysWhich) {
  Points points = two_panels_probed();
  // Three holes of the left panel that probes fell into, too many near each other to be outliers.
  std::vector<Void> holes;
  for (const std::size_t i : {13 * 5 + 3, 13 * 5 + 4, 13 * 6 + 3}) {
    points[i].measured.height = mm(0.1);
    holes.push_back({Circle{points[i].place, mm(1.5)}, "hole of tool 3", {"panel.exc", 40, 1}});
  }
  auto voids = Voids::make(holes, mm(0.5));
  ASSERT_TRUE(voids) << voids.error().text();
  const auto map = ZonedMap::of_probes(points, {kLeft}, *std::move(voids));
  ASSERT_TRUE(map) << map.error().text();
  ASSERT_EQ(map->unused().size(), 3U + 6 * 13);
  EXPECT_EQ(map->unused()[0].reason, "it lies in no zone");
  const auto in_hole = std::ranges::find(map->unused(), 13U * 5 + 3, &UnusedProbe::i_point);
  ASSERT_NE(in_hole, map->unused().end());
  EXPECT_EQ(in_hole->reason, "it lies in \"hole of tool 3\" (panel.exc:40)");
  EXPECT_TRUE(map->map(0).outliers().empty());
  const auto found = map->height_at(points[13 * 5 + 3].place);
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->height.source, HeightSource::InVoid);
  EXPECT_EQ(found->in_void, "\"hole of tool 3\" (panel.exc:40)");
  // PredictedHeight by its neighbours.
  EXPECT_NEAR(found->height.height.in_mm(), two_panels(points[13 * 5 + 3].place.in_mm()), 0.005);
  const auto beside = map->height_at(
      at(points[13 * 5 + 3].place.in_mm().x() + 2.1, points[13 * 5 + 3].place.in_mm().y()));
  EXPECT_NE(beside->height.source, HeightSource::InVoid);
  EXPECT_TRUE(beside->in_void.empty());

  const LatticeAxis x{-150, 25, 13}, y{-150, 25, 13};
  const auto measured = height_grid(*map, x, y), filled = height_grid(*map, x, y, GridFill::Filled);
  ASSERT_TRUE(measured && filled);
  EXPECT_FALSE(measured->heights[13 * 5 + 3]);
  EXPECT_TRUE(filled->heights[13 * 5 + 3]);
  EXPECT_TRUE(measured->heights[13 * 5 + 2]);
  EXPECT_FALSE(filled->heights[13 * 5 + 8]);
}

TEST(ZonedMap, DoesNotBelieveAProbeWhoseTipMayTouchAVoid) {
  const Points points = two_panels_probed();
  const auto beside = points[13 * 5 + 3].place + displacement_mm<frame::Nominal>(1.8, 0);
  auto voids = Voids::make({{Circle{beside, mm(1.5)}, "clamp", {"zones.toml", 4, 8}}}, mm(0.5));
  ASSERT_TRUE(voids) << voids.error().text();
  const auto map = ZonedMap::of_probes(points, {kLeft, kRight}, *std::move(voids));
  ASSERT_TRUE(map) << map.error().text();
  ASSERT_EQ(map->unused().size(), 1U);
  EXPECT_EQ(map->unused()[0].reason, "it may touch \"clamp\" (zones.toml:4)");
  // There is a surface all the same.
  EXPECT_NE(map->height_at(points[13 * 5 + 3].place)->height.source, HeightSource::InVoid);
  EXPECT_EQ(map->height_at(beside)->height.source, HeightSource::InVoid);
}

TEST(ZonedMap, GivesManyHeightsAsOneByOne) {
  const Points points = two_panels_probed();
  auto voids = Voids::make({{Circle{at(-60, 10), mm(20)}, "hole", {}}});
  const auto zoned = ZonedMap::of_probes(points, {kRight, kLeft}, *voids);
  const auto plain = ZonedMap::of_probes(
      points, {}, *voids, {.model = SurfaceModel::Plane, .outliers = {.most_noise = 1e6}});
  ASSERT_TRUE(zoned) << zoned.error().text();
  ASSERT_TRUE(plain) << plain.error().text();
  for (const ZonedMap& map : {*zoned, *plain}) {
    Random random(155);
    std::vector<Eigen::Vector2d> places_mm;
    while (places_mm.size() < 2000) {
      const Eigen::Vector2d p_mm(random.uniform(-154, 154), random.uniform(-154, 154));
      if (map.height_at(position_mm<frame::Nominal>(p_mm))) places_mm.push_back(p_mm);
    }
    std::vector<double> heights_mm(places_mm.size());
    std::vector<HeightSource> sources(places_mm.size());
    ASSERT_TRUE(map.heights_at(places_mm, heights_mm, sources));
    int n_void = 0;
    for (std::size_t i = 0; i < places_mm.size(); ++i) {
      const auto one = map.height_at(position_mm<frame::Nominal>(places_mm[i]));
      EXPECT_EQ(mm(heights_mm[i]), one->height.height);
      EXPECT_EQ(sources[i], one->height.source);
      n_void += sources[i] == HeightSource::InVoid ? 1 : 0;
    }
    EXPECT_GT(n_void, 10);
    places_mm[7] = {7, 500};
    EXPECT_FALSE(map.heights_at(places_mm, heights_mm));
    EXPECT_FALSE(map.heights_at(places_mm, std::span(heights_mm).first(3)));
  }
}

TEST(ZonedMap, IsOneMapWithoutZones) {
  Random random(151);
  const test::SimulatedWarp warp(random, 1);
  const Points points = probed_lattice(random, warp, 7, 6);
  const auto map = ZonedMap::of_probes(points, {}, {}, {.model = SurfaceModel::ThinPlate});
  const auto plain = HeightMap::of_probes(points, {.model = SurfaceModel::ThinPlate});
  ASSERT_TRUE(map) << map.error().text();
  ASSERT_TRUE(plain) << plain.error().text();
  EXPECT_EQ(map->height_at(at(20, 30))->height.height, plain->height_at(at(20, 30))->height);
  EXPECT_THAT(map->height_at(at(500, 0)), FailsWith(Code::GridInvalid));
}

TEST(ZonedMap, NamesTheZoneInItsRefusals) {
  const Points points = two_panels_probed();
  const Zone empty = {rectangle(at(200, 200), at(300, 300)), "coupon"};
  EXPECT_THAT(ZonedMap::of_probes(points, {kLeft, empty}, {}),
              FailsWith(Code::GridInvalid, "\"coupon\": 0 probes"));
  EXPECT_THAT(ZonedMap::of_probes(points, {kLeft, kLeft}, {}),
              FailsWith(Code::ConfigValue, "\"left\""));
  EXPECT_THAT(ZonedMap::of_probes(points, {{Circle{at(0, 0), mm(-1)}, "round"}}, {}),
              FailsWith(Code::ConfigValue, "-1 mm"));
  const Zone wide = {rectangle(at(-300, -300), at(2, 300)), "wide"};
  const auto map = ZonedMap::of_probes(points, {wide}, {});
  ASSERT_TRUE(map) << map.error().text();
  EXPECT_THAT(map->height_at(at(-290, 0)),
              FailsWith(Code::GridInvalid, "\"wide\": (-290.000, 0.000)"));
}

}  // namespace
}  // namespace panelcal
