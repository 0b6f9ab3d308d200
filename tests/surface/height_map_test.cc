// SPDX-License-Identifier: Apache-2.0
#include "panelcal/surface/height_map.h"

#include <cmath>
#include <limits>
#include <tuple>

#include <gmock/gmock.h>

#include "tests/support/matchers.h"
#include "tests/surface/simulated_warp.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FailsWith;
using test::probed_lattice;
using test::SimulatedWarp;
using ::testing::HasSubstr;
using Points = std::vector<ProbePoint>;

Position<frame::Nominal> at(double x_mm, double y_mm) {
  return position_mm<frame::Nominal>(x_mm, y_mm);
}

HeightMap made(const Points& points, const HeightMapOptions& options = {}) {
  auto map = HeightMap::of_probes(points, options);
  EXPECT_TRUE(map) << map.error().text();
  return *std::move(map);
}

/// 7 columns 50 mm apart, 6 rows 60 mm apart, about the origin.
Points warped(std::uint64_t seed, int kind = 3) {
  Random random(seed);
  const SimulatedWarp warp(random, kind);
  return probed_lattice(random, warp, 7, 6);
}

TEST(HeightMap, IsItsSurfaceButForTheLattice) {
  const HeightMap map = made(warped(41));
  Random random(42);
  for (int i = 0; i < 200; ++i) {
    const auto place = at(random.uniform(-150, 150), random.uniform(-150, 150));
    const HeightEstimate right = map.surface().at(place);
    const auto found = map.height_at(place);
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_NEAR(found->height / right.sigma, right.height / right.sigma, 0.2);
    EXPECT_NEAR(found->sigma / right.sigma, 1, 0.1);
  }
  EXPECT_LT(map.lattice_error(), um(1));
}

TEST(HeightMap, SaysWhichHeightsAreMeasuredFilledAndExtrapolated) {
  Points points = warped(43);
  points.erase(points.begin() + 7 * 2 + 3);  // column 3, row 2: (0, -30)
  const HeightMap map = made(points);
  for (const auto& [x_mm, y_mm, source] : {std::tuple(-50.0, -30.0, HeightSource::Measured),
                                           std::tuple(0.0, -30.0, HeightSource::Filled),
                                           std::tuple(20.0, -10.0, HeightSource::Filled),
                                           std::tuple(26.0, -30.0, HeightSource::Measured),
                                           std::tuple(0.0, 1.0, HeightSource::Measured),
                                           std::tuple(150.0, 150.0, HeightSource::Measured),
                                           std::tuple(152.0, 0.0, HeightSource::Extrapolated)}) {
    const auto found = map.height_at(at(x_mm, y_mm));
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_EQ(found->source, source) << x_mm << " " << y_mm;
  }
  EXPECT_EQ(map.height_at(at(152, 0))->outside, mm(2));
  EXPECT_EQ(map.height_at(at(-150, 0))->outside, mm(0));
}

TEST(HeightMap, FillsWhereAWildProbeWasLeftOut) {
  Points points = warped(44);
  points[7 * 2 + 3].measured.height = points[7 * 2 + 3].measured.height + mm(0.5);
  const HeightMap map = made(points);
  ASSERT_EQ(map.outliers().size(), 1U);
  EXPECT_THAT(map.outliers()[0].text(), HasSubstr("column 3 row 2"));
  EXPECT_EQ(map.height_at(at(0, -30))->source, HeightSource::Filled);
}

TEST(HeightMap, RefusesToExtrapolateFarther) {
  const HeightMap map = made(warped(45), {.max_extrapolation = mm(3)});
  EXPECT_TRUE(map.height_at(at(152.9, 0)));
  EXPECT_THAT(map.height_at(at(153.1, 0)),
              FailsWith(Code::GridInvalid, "(153.100, 0.000) lies 3.100 mm outside"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(map.height_at(at(0, nan)), FailsWith(Code::GridInvalid, "at no place"));
  const HeightMap none = made(warped(45), {.max_extrapolation = mm(0)});
  EXPECT_TRUE(none.height_at(at(150, -150)));
  EXPECT_FALSE(none.height_at(at(150.01, 0)));
}

TEST(HeightMap, GivesTheSameHeightsToMany) {
  // A triangle of probes: much of its rectangle lies outside of the hull.
  Points points;
  for (const ProbePoint& point : warped(46)) {
    const Vector2d p_mm = point.place.in_mm();
    if (p_mm.x() + p_mm.y() < 1) points.push_back(point);
  }
  const HeightMap map = made(points, {.max_extrapolation = mm(4)});
  Random random(47);
  std::vector<Vector2d> places_mm;
  while (places_mm.size() < 1000) {
    const Vector2d p_mm(random.uniform(-155, 155), random.uniform(-155, 155));
    if (map.height_at(position_mm<frame::Nominal>(p_mm))) places_mm.push_back(p_mm);
  }
  std::vector<double> heights_mm(places_mm.size());
  ASSERT_TRUE(map.heights_at(places_mm, heights_mm));
  for (std::size_t i = 0; i < places_mm.size(); ++i) {
    const auto place = position_mm<frame::Nominal>(places_mm[i]);
    EXPECT_EQ(heights_mm[i], map.height_at(place)->height.in_mm());
  }
  for (const Vector2d& bad : {Vector2d(100, 100), Vector2d(1e300, 0), Vector2d(0, std::nan(""))}) {
    std::vector<Vector2d> with_bad = places_mm;
    with_bad[500] = bad;
    EXPECT_THAT(map.heights_at(with_bad, heights_mm), FailsWith(Code::GridInvalid, ""));
  }
}

TEST(HeightMap, TakesTheSimplestModelThatForetells) {
  Random random(48);
  const auto tilted = [](const Vector2d& p_mm) { return 1.6 + 1e-3 * p_mm.x(); };
  const HeightMap plane = made(probed_lattice(random, tilted, 6, 6));
  EXPECT_EQ(plane.surface().model(), SurfaceModel::Plane);
  EXPECT_THAT(plane.reason(), HasSubstr("the plane is the simplest"));
  const HeightMap bent = made(warped(49, 1));
  EXPECT_NE(bent.surface().model(), SurfaceModel::Plane);
}

}  // namespace
}  // namespace panelcal
