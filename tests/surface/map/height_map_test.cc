// SPDX-License-Identifier: Apache-2.0
#include "surface/map/height_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "surface/fit/choice.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"
#include "tests/surface/fit/simulated_warp.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FailsWith;
using test::probed_lattice;
using test::SimulatedWarp;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
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

TEST(HeightMap, KnowsWhatItsLatticeMisses) {
  // A steep step: in the middle of its cells the lattice misses less than beside it.
  Random random(59);
  const auto step = [](const Vector2d& p_mm) {
    return 2e-3 * (p_mm.x() + p_mm.y()) + 0.3 * std::tanh(p_mm.x() / 25);
  };
  const HeightMap map = made(probed_lattice(random, step, 31, 4, 1e-5),
                             {.model = SurfaceModel::GaussianProcess, .max_extrapolation = mm(0)});
  double worst_mm = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto place = at(random.uniform(-150, 150), random.uniform(-150, 150));
    const auto found = map.height_at(place);
    ASSERT_TRUE(found) << found.error().text();
    const HeightEstimate right = map.surface().at(place);
    worst_mm = std::max(worst_mm, std::abs((found->height - right.height).in_mm()));
  }
  // If only the middles were tried, it would be 1.05 times as much.
  EXPECT_LT(worst_mm, 1.02 * map.lattice_error().in_mm());
  EXPECT_GT(worst_mm, 1e-4);
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

Points jittered(Points points, double jitter_mm) {
  Random random(50);
  for (ProbePoint& point : points) {
    const Vector2d p_mm = point.place.in_mm();
    const double x_mm = p_mm.x() + jitter_mm * random.normal();
    point.place = at(x_mm, p_mm.y() + jitter_mm * random.normal());
  }
  return points;
}

HeightSource source_at(const HeightMap& map, double x_mm, double y_mm) {
  const auto found = map.height_at(at(x_mm, y_mm));
  EXPECT_TRUE(found) << found.error().text();
  return found ? found->source : HeightSource::Extrapolated;
}

TEST(HeightMap, VouchesNoFartherForAMissingRowOrProbesOffTheirColumns) {
  Points gap = warped(51);
  gap.erase(gap.begin() + 7 * 2, gap.begin() + 7 * 3);  // row 2: y = -30
  for (const double jitter_mm : {0.0, 0.001, 0.01, 1.0}) {
    const HeightMap map = made(jittered(gap, jitter_mm));
    EXPECT_EQ(source_at(map, 0, -30), HeightSource::Filled) << jitter_mm;
    EXPECT_EQ(source_at(map, 20, -40), HeightSource::Filled) << jitter_mm;
    EXPECT_EQ(source_at(map, 0, 60), HeightSource::Measured) << jitter_mm;
    // Nothing between four probes of the lattice is filled.
    for (double t = 0; t < 1; t += 0.05) {
      EXPECT_EQ(source_at(map, 25 + 2 * t, 60 + 2 * t), HeightSource::Measured) << jitter_mm;
    }
    Points hole = jittered(warped(51), jitter_mm);
    hole.erase(hole.begin() + 7 * 2 + 3);  // column 3, row 2: (0, -30)
    const HeightMap holed = made(hole, {.model = SurfaceModel::ThinPlate});
    EXPECT_EQ(source_at(holed, 0, -30), HeightSource::Filled) << jitter_mm;
    EXPECT_EQ(source_at(holed, 15, -20), HeightSource::Filled) << jitter_mm;
  }
}

TEST(HeightMap, VouchesForMostBetweenScatteredProbes) {
  Random random(52);
  const SimulatedWarp warp(random, 3);
  Points points;
  for (int i = 0; i < 100; ++i) {
    const Vector2d p_mm(random.uniform(-150, 150), random.uniform(-150, 150));
    // A disc of 60 mm is left out.
    if (p_mm.norm() < 60) continue;
    points.push_back({position_mm<frame::Nominal>(p_mm), {mm(warp(p_mm)), um(3)}, "", {}});
  }
  const HeightMap map = made(points);
  for (const ProbePoint& point : points) {
    EXPECT_EQ(map.height_at(point.place)->source, HeightSource::Measured);
  }
  for (double x_mm = -40; x_mm <= 40; x_mm += 10) {
    EXPECT_EQ(source_at(map, x_mm, 0), HeightSource::Filled) << x_mm;
  }
}

TEST(HeightMap, VouchesAsFarForPlacesThatWereProbedAgain) {
  Points points = warped(48, 1);
  const std::size_t n = points.size();
  Random random(48);
  // Twice more, each time some hundredths beside.
  for (std::size_t i = 0; i < 2 * n; ++i) {
    points.push_back(points[i % n]);
    const Vector2d beside_mm(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05));
    points.back().place = at(points.back().place.in_mm().x() + beside_mm.x(),
                             points.back().place.in_mm().y() + beside_mm.y());
  }
  const HeightMap map = made(points, {.model = SurfaceModel::ThinPlate});
  // In the middle of a cell, 25 mm and 30 mm from its probes.
  EXPECT_EQ(map.height_at(at(0, 0))->source, HeightSource::Measured);
  EXPECT_EQ(map.height_at(at(25, 30))->source, HeightSource::Measured);
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
  EXPECT_THAT(map.height_at(at(153.1, 0)), FailsWith(Code::GridInvalid, "3.100 mm"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(map.height_at(at(0, nan)), FailsWith(Code::GridInvalid));
  const HeightMap none = made(warped(45), {.max_extrapolation = mm(0)});
  EXPECT_TRUE(none.height_at(at(150, -150)));
  EXPECT_FALSE(none.height_at(at(150.01, 0)));
  for (const double bad_mm : {-1.0, 1000.1, 1e300, nan}) {
    EXPECT_THAT(HeightMap::of_probes(warped(45), {.max_extrapolation = mm(bad_mm)}),
                FailsWith(Code::ConfigValue, "max_extrapolation_mm"));
  }
  EXPECT_THAT(HeightMap::of_probes(warped(45), {.outliers = {.most = -1}}),
              FailsWith(Code::ConfigValue, "-1"));
}

/// As far as the lattice goes, whatever the probes' spacing.
constexpr int kMostLatticeNodes = 130000;

int n_nodes(const HeightMap& map) {
  return map.lattice().x().n_nodes * map.lattice().y().n_nodes;
}

Points scaled(Points points, double by_x, double by_y) {
  for (ProbePoint& point : points) {
    const Vector2d p_mm = point.place.in_mm();
    point.place = at(by_x * p_mm.x(), by_y * p_mm.y());
  }
  return points;
}

TEST(HeightMap, HasALatticeOfLimitedSize) {
  // On 0.1 mm, in a strip of 10 um, and far beyond.
  HeightMapOptions options{.model = SurfaceModel::Plane};
  Random random(53);
  const auto flat = [](const Vector2d&) { return 1.6; };
  const Points points = probed_lattice(random, flat, 7, 6);
  for (const double far_mm : {0.0, 5.0, 1000.0}) {
    options.max_extrapolation = mm(far_mm);
    for (const auto& [by_x, by_y] :
         {std::pair(1.0, 1.0), std::pair(1e-4, 3e-4), std::pair(1.0, 1e-5)}) {
      const HeightMap map = made(scaled(points, by_x, by_y), options);
      EXPECT_LT(n_nodes(map), kMostLatticeNodes);
      EXPECT_TRUE(map.height_at(at(150 * by_x + far_mm, 0)));
    }
  }
}

TEST(HeightMap, RefusesProbesThatNearlyLieInOneLine) {
  Random random(54);
  const auto flat = [](const Vector2d&) { return 1.6; };
  const Points points = probed_lattice(random, flat, 7, 6);
  for (const auto& [by_x, by_y] : {std::pair(1.0, 1e-6), std::pair(1e-8, 1e-8)}) {
    EXPECT_THAT(HeightMap::of_probes(scaled(points, by_x, by_y), {.model = SurfaceModel::Plane}),
                FailsWith(Code::GridInvalid, "one line"));
  }
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
    EXPECT_THAT(map.heights_at(with_bad, heights_mm), FailsWith(Code::GridInvalid));
  }
  heights_mm.pop_back();
  EXPECT_THAT(map.heights_at(places_mm, heights_mm),
              FailsWith(Code::GridInvalid, "1000 places, 999 heights"));
}

TEST(HeightMap, SaysWhereManyHeightsComeFrom) {
  Points points = warped(55);
  points.erase(points.begin() + 7 * 2 + 3);  // (0, -30)
  const HeightMap map = made(points);
  const std::vector<Vector2d> places_mm = {{-50, -30}, {0, -30}, {152, 0}, {100, 90}};
  std::vector<double> heights_mm(4);
  std::vector<HeightSource> sources(4);
  ASSERT_TRUE(map.heights_at(places_mm, heights_mm, sources));
  EXPECT_THAT(sources,
              ElementsAre(HeightSource::Measured,
                          HeightSource::Filled,
                          HeightSource::Extrapolated,
                          HeightSource::Measured));
  EXPECT_EQ(heights_mm[1], map.height_at(at(0, -30))->height.in_mm());
  EXPECT_THAT(map.heights_at(std::vector<Vector2d>(4, Vector2d(160, 0)), heights_mm, sources),
              FailsWith(Code::GridInvalid, "10.000 mm"));
  sources.pop_back();
  EXPECT_THAT(map.heights_at(places_mm, heights_mm, sources),
              FailsWith(Code::GridInvalid, "4 heights"));
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

TEST(HeightMap, SaysIfNothingChecksItsModel) {
  Random random(56);
  const auto tilted = [](const Vector2d& p_mm) { return 1.6 + 1e-3 * p_mm.x(); };
  Points points = probed_lattice(random, tilted, 2, 2);
  EXPECT_THAT(made(points).reason(), Not(HasSubstr("no model is checked")));
  points.pop_back();
  const HeightMap map = made(points);
  EXPECT_THAT(map.reason(), HasSubstr("no model is checked; the plane is the simplest"));
  EXPECT_EQ(map.surface().model(), SurfaceModel::Plane);
}

TEST(HeightMap, OfThreePlacesIsTheirPlaneHoweverOftenEachWasProbed) {
  // The fourth round stands 2 um off, as the scales of a stage may say.
  Points points;
  for (int i = 0; i < 12; ++i) {
    const double off_mm = i < 9 ? 0 : 0.002;
    ProbePoint point;
    point.place = at(off_mm + (i % 3 == 1 ? 100 : 0), i % 3 == 2 ? 100 : 0);
    const Vector2d p_mm = point.place.in_mm();
    const double scatter_mm = i < 6 ? 0.001 : -0.001;
    point.measured = {mm(1.6 + 1e-4 * p_mm.x() + 2e-4 * p_mm.y() + scatter_mm), um(2)};
    points.push_back(point);
  }
  for (const bool is_stated : {true, false}) {
    for (ProbePoint& point : points) point.is_sigma_assumed = !is_stated;
    const HeightMap map = made(points);
    EXPECT_EQ(map.surface().model(), SurfaceModel::Plane);
    EXPECT_THAT(map.reason(), HasSubstr("12 probes at three places show no bending"));
    const auto found = map.height_at(at(30, 30));
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_NEAR(found->height.in_mm(), 1.609, 1e-6);
    // Weights 0.4, 0.3 and 0.3 of the corners, of four readings each.
    EXPECT_NEAR(found->sigma.in_um(), is_stated ? 2 * std::sqrt(0.34) / 2 : 0.5, 0.2);
  }
}

TEST(HeightMap, TakesNoBowThatASingleProbeTells) {
  // Two tilted rows, and one probe between them that lies 20 sigma low: the bow through it misses
  // no other, but a plane that predicts it badly is not better either.
  Random random(57);
  const auto tilted = [](const Vector2d& p_mm) { return 1.6 + 1e-3 * p_mm.x(); };
  Points points = probed_lattice(random, tilted, 9, 2);
  points.push_back(points.back());
  points.back().place = at(0, 0);
  points.back().measured.height = mm(1.6) - 20 * points.back().measured.sigma;
  const auto found = choose_surface(points, {.false_alarm = 1e-300, .most_noise = 1e9});
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->surface.fit.model(), SurfaceModel::Plane) << found->reason;
}

}  // namespace
}  // namespace panelcal
